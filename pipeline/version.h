#pragma once

#include <map>
#include <string>

namespace sinew {

/// Sinew's own version, such as "0.1.0".
std::string version();

/// Versions of Sinew, the compiler and the libraries that results depend on.
std::map<std::string, std::string> component_versions();

}  // namespace sinew
