// SHA-256 as lower-case hexadecimal text (FIPS 180-4), by OpenSSL.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

namespace host {

std::string sha256_of_text(std::string_view text);

/// Of a regular file, read in pieces. Throws InputError if it cannot be read.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace host
