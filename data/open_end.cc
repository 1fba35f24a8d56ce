#include "data/open_end.h"

namespace sinew {

void warn_of_open_end(const std::string& path, std::string_view content,
                      std::vector<Warning>& warnings) {
  if (content.empty() || std::string_view(" \t\r\n\v\f").find(content.back()) != content.npos) {
    return;
  }
  warnings.push_back(
      {{path, 0},
       "the last row has no line end; if the file was cut there, its last number lacks digits"});
}

}  // namespace sinew
