// What diagnosis says about effects in words: what they look like, which motion shows them, and what tells two apart.
#pragma once

#include <string>
#include <vector>

namespace host::diagnosis {

/// "a camera clock that is late", for the sentence.
std::string looks_like(const std::string& effect);
/// The motion that shows an effect: "quick turns and changes of speed".
std::string needs(const std::string& effect);
/// The motion that tells two effects apart.
std::string separates(const std::string& a, const std::string& b);

}  // namespace host::diagnosis
