// Runs a fuzz target without a fuzzer, from fixed seeds: on random bytes or, with a corpus, on its files as they are
// and then changed in a few places. A failing seed is printed last and runs alone:
//   fuzz_NAME_seeds SEED 1 [CORPUS]
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "mutate.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

namespace fs = std::filesystem;

std::vector<Mutator::Bytes> read_corpus(const fs::path& folder) {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  std::vector<Mutator::Bytes> corpus;
  for (const fs::path& file : files) {
    std::ifstream in(file, std::ios::binary);
    corpus.emplace_back(std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>());
  }
  if (corpus.empty()) {
    std::fprintf(stderr, "%s: expected files to begin from\n", folder.c_str());
    std::exit(2);
  }
  return corpus;
}

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1,
                      count = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 20;
  const std::vector<Mutator::Bytes> corpus = argc > 3 ? read_corpus(argv[3]) : std::vector<Mutator::Bytes>();
  for (std::size_t i = 0; i < corpus.size(); ++i) {
    std::printf("file %zu of the corpus\n", i);
    std::fflush(stdout);
    LLVMFuzzerTestOneInput(corpus[i].data(), corpus[i].size());
  }
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    std::fflush(stdout);
    Mutator mutator(seed);
    const Mutator::Bytes bytes = corpus.empty() ? mutator.random_bytes() : mutator.changed(corpus);
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  return 0;
}
