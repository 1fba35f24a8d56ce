#pragma once

#include <span>
#include <string>
#include <string_view>

namespace sinew {

/// A field of a library's options and the option of the command line that sets it.
struct OptionName {
  std::string_view structure, field, option;
};
/// All of them, for tests too.
std::span<const OptionName> option_names();

/// A message of the library as the command line's user reads it: `WholeBodyOptions::height` becomes
/// `--height`, a field that no option sets its words: `GaitOptions.least_share`, `least share`.
/// O(length).
std::string in_words_of_options(const std::string& message);

}  // namespace sinew
