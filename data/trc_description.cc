#include "data/trc_description.h"

#include <cmath>
#include <utility>

#include "data/trc_header.h"

namespace sinew {

TrcDescription read_trc_description(const std::filesystem::path& path) {
  const std::string content = text::read_text_file(path, "a TRC file");
  MarkerFile file;
  file.path = path.string();
  text::LineReader lines(content);
  const trc::Header header = trc::parse_header(file.path, lines);
  TrcDescription description;
  description.metres_per_unit = std::pow(10.0, header.decimal_shift);
  trc::parse_columns(header, lines, file, &description.labels);
  return description;
}

}  // namespace sinew
