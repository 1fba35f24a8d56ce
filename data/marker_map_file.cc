#include <fmt/format.h>

#include <set>

#include "data/csv_file.h"
#include "data/marker_matching.h"
#include "data/text.h"

namespace sinew {

MarkerMap read_marker_map(const std::filesystem::path& path) {
  const std::string content = text::read_text_file(path, "a map of markers");
  text::LineReader lines(content);
  MarkerMap map;
  std::set<std::string> recorded, model;
  bool labelled = false;
  while (const std::optional<text::Line> line = lines.next_filled()) {
    if (text::trim(line->text).starts_with('#')) continue;
    const SourceLocation at{path.string(), line->number};
    const std::vector<std::string> cells = csv_cells(at, line->text);
    if (!labelled) {
      labelled = cells.size() == 2 && cells[0] == "recorded" && cells[1] == "model";
      if (!labelled) {
        throw InputError(at, {"a map of markers begins with its labels", "recorded,model",
                              std::string(line->text), "Add this line."});
      }
      continue;
    }
    if (cells.size() != 2 || cells[0].empty()) {
      throw InputError(at,
                       {"a row of a map has two names", "recorded,model", std::string(line->text),
                        "Leave the model's name empty for markers that shall not be used."});
    }
    if (!recorded.insert(cells[0]).second ||
        (!cells[1].empty() && !model.insert(cells[1]).second)) {
      throw InputError(at, {"a name stands twice in the map", "each name once",
                            std::string(line->text), "Remove one of the rows."});
    }
    map.emplace_back(cells[0], cells[1]);
  }
  if (!labelled) {
    throw InputError({path.string()},
                     {"a map of markers begins with its labels", "recorded,model", "", ""});
  }
  return map;
}

std::string marker_map_csv(const MarkerMap& map) {
  std::string text = "recorded,model\n";
  for (const auto& [recorded, model] : map) {
    text += fmt::format("{},{}\n", csv_cell(recorded), csv_cell(model));
  }
  return text;
}

}  // namespace sinew
