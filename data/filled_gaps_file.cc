#include <algorithm>
#include <optional>

#include "data/csv_file.h"
#include "data/gap_filling.h"
#include "data/text.h"

namespace sinew {
namespace {

int frame_numbered(const MarkerTrajectories& markers, const std::string& text) {
  const std::optional<long long> number = text::parse_integer(text);
  if (!number) return -1;
  const auto found = std::find(markers.frame_numbers.begin(), markers.frame_numbers.end(), *number);
  return found == markers.frame_numbers.end()
             ? -1
             : static_cast<int>(found - markers.frame_numbers.begin());
}

}  // namespace

std::vector<MarkerGap> read_filled_gaps(const std::filesystem::path& path,
                                        const MarkerTrajectories& markers) {
  const std::string content = text::read_text_file(path, "a list of filled samples");
  text::LineReader lines(content);
  std::vector<MarkerGap> gaps;
  bool labelled = false;
  while (const std::optional<text::Line> line = lines.next_filled()) {
    const SourceLocation at{path.string(), line->number};
    const std::vector<std::string> cells = csv_cells(at, line->text);
    if (!labelled) {
      labelled = line->text.starts_with("marker,first_frame,last_frame");
      if (!labelled) {
        throw InputError(at, {"is no list of filled samples",
                              "labels marker,first_frame,last_frame,...", std::string(line->text),
                              "Give the list that `sinew run --c3d` or `sinew convert` wrote."});
      }
      continue;
    }
    const int marker = markers.find_marker(cells[0]);
    const int first = cells.size() >= 3 ? frame_numbered(markers, cells[1]) : -1;
    const int last = cells.size() >= 3 ? frame_numbered(markers, cells[2]) : -1;
    if (marker < 0 || first < 0 || last < first) {
      throw InputError(at, {"names a marker or frames that the recording does not have",
                            "a marker, its first and its last filled frame",
                            std::string(line->text), "Give the list of this recording."});
    }
    gaps.push_back({marker, first, last - first + 1});
  }
  return gaps;
}

}  // namespace sinew
