#include <algorithm>
#include <cmath>
#include <optional>

#include "data/csv_file.h"
#include "data/gap_filling.h"
#include "data/numbers.h"
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

std::optional<FilledGap::Method> method_called(const std::string& name) {
  if (name == "spline") return FilledGap::Method::kSpline;
  if (name == "rigid") return FilledGap::Method::kRigid;
  if (name == "none") return FilledGap::Method::kNone;
  return std::nullopt;
}

// Method and error, of which lists of other programs may have neither.
bool read_quality(const std::vector<std::string>& cells, FilledGap& filled) {
  filled.error = kNaN;
  if (cells.size() > 6 && !cells[6].empty()) {
    const auto method = method_called(cells[6]);
    if (!method) return false;
    filled.method = *method;
  }
  if (cells.size() > 7 && !cells[7].empty()) {
    const auto error = text::parse_number(cells[7]);
    if (!error || !(*error >= 0.0)) return false;
    filled.error = *error;
  }
  return true;
}

}  // namespace

std::vector<FilledGap> read_filled_gaps(const std::filesystem::path& path,
                                        const MarkerTrajectories& markers) {
  const std::string content = text::read_text_file(path, "a list of filled samples");
  text::LineReader lines(content);
  std::vector<FilledGap> gaps;
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
    FilledGap filled;
    filled.gap = {marker, first, last - first + 1};
    if (!read_quality(cells, filled)) {
      throw InputError(
          at, {"tells no method and error", "spline, rigid or none, and a distance [m] or nothing",
               std::string(line->text), "Correct the cells method and error_m."});
    }
    gaps.push_back(std::move(filled));
  }
  return gaps;
}

}  // namespace sinew
