// Results, kept segments and manifests in JSON, as the program reads them: the first byte says which file the rest is.
#include "compare/parameters.h"
#include "files/manifest.h"
#include "fuzz_files.h"
#include "replay/kept_segments.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace host;
  static const FuzzFolder folder;
  if (size < 1) return 0;
  const std::string text(reinterpret_cast<const char*>(data) + 1, size - 1);
  switch (data[0] % 4) {
    case 0:
      folder.put("result/result.json", text);
      reads([&] {
        const ParameterList list = read_parameters(folder.path() / "result");
        differences(list, list);
      });
      break;
    case 1: {
      const auto file = folder.put("truth.json", text);
      reads([&] { read_truth_parameters(file); });
      break;
    }
    case 2:
      folder.put("kept/kept_segments.json", text);
      reads([&] { kept_segments_json(read_kept_segments(folder.path() / "kept")); });
      break;
    default:
      folder.put("listed/manifest.json", text);
      reads([&] {
        check_folder(folder.path() / "listed");
        manifest_json(read_manifest(folder.path() / "listed"));
      });
  }
  return 0;
}
