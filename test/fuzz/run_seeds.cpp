// Runs a fuzz target without a fuzzer: random inputs from fixed seeds, for the tests. A failing seed is printed and runs alone:
//   fuzz_NAME_seeds SEED 1
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size);

namespace {

std::uint64_t next(std::uint64_t* state) {  // splitmix64 (Steele, Lea and Flood 2014)
  std::uint64_t z = (*state += 0x9E3779B97F4A7C15ull);
  z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9ull;
  z = (z ^ (z >> 27)) * 0x94D049BB133111EBull;
  return z ^ (z >> 31);
}

}  // namespace

int main(int argc, char** argv) {
  const std::uint64_t first = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1, count = argc > 2 ? std::strtoull(argv[2], nullptr, 10) : 20;
  for (std::uint64_t seed = first; seed < first + count; ++seed) {
    std::printf("seed %llu\n", static_cast<unsigned long long>(seed));
    std::fflush(stdout);
    std::uint64_t state = seed;
    std::vector<std::uint8_t> bytes(16 + next(&state) % 112);
    for (std::uint8_t& b : bytes) b = static_cast<std::uint8_t>(next(&state));
    LLVMFuzzerTestOneInput(bytes.data(), bytes.size());
  }
  return 0;
}
