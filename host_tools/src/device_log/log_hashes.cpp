// Result hashes as a device or a program left them.
#include "csv.h"
#include "device_log/device_log.h"

namespace host {

std::vector<std::uint64_t> read_hashes(const std::filesystem::path& file) {
  std::vector<std::uint64_t> hashes;
  if (is_device_log(file)) {
    for (const Recording& session : read_device_log(file).sessions) {
      for (const DeviceCall& call : session.device->calls) {
        if (call.what == DeviceCall::hash) hashes.push_back(call.hash_value);
      }
    }
    if (hashes.empty())
      throw InputError(file.string() + ": expected a result hash in the log (segcal_log_hash), found none");
    return hashes;
  }
  expect_regular_file(file);
  const std::string text = read_file(file), word = "result_hash";
  const std::size_t at = text.find(word);
  const std::size_t from =
      at == std::string::npos ? at : text.find_first_of("0123456789abcdefABCDEF", at + word.size());
  const std::size_t to = from == std::string::npos ? from : text.find_first_not_of("0123456789abcdefABCDEF", from);
  const std::string digits = from == std::string::npos ? "" : text.substr(from, to - from);
  if (digits.size() != 16)
    throw InputError(file.string() + ": expected 'result_hash' and 16 hexadecimal digits, found '" +
                     digits.substr(0, 20) + "'");
  return {std::stoull(digits, nullptr, 16)};
}

std::string hash_text(std::uint64_t hash) {
  char text[20];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(hash));
  return text;
}

}  // namespace host
