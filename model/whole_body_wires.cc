#include "model/whole_body_wires.h"

#include <fmt/format.h>

#include <array>
#include <map>
#include <set>
#include <vector>

#include "model/whole_body_skeleton.h"

namespace sinew::anatomy {
namespace {

using Eigen::Vector3d;

constexpr std::array<const char*, 3> kRegions = {"leg", "trunk", "arm"};
constexpr double kShortestPath = 0.005;  // [m] shorter ones have no direction to speak of
constexpr double kLongestFiber = 1.5;    // of the optimal length, see PathElement::natural_length

// What is not on one side stands in the midline, or the body would not be symmetric.
void require_midline(const TableRow& row, std::string_view column) {
  if (is_right(row.cell(column)) || row.number("z") == 0.0) return;
  row.fail("z", "0, or a name that ends in _r", row.cell("z"), "Name the side, or move it.");
}

void require_side(const TableRow& row, std::string_view column) {
  if (!is_right(row.cell("bone")) || is_right(row.cell(column))) return;
  row.fail(column, "a name that ends in _r, as its bone's does", row.cell(column), "Add the side.");
}

struct Landmark {
  int body = 0;
  Vector3d p_BP = Vector3d::Zero();
};

bool is_at_level(const TableRow& row, bool detailed) {
  const std::string level = row.text("level");
  if (level != "simplified" && level != "detailed" && level != "both") {
    row.fail("level", "simplified, detailed or both", level, "Correct the level.");
  }
  return level == "both" || (level == "detailed") == detailed;
}

class PathReader {
 public:
  PathReader(std::span<const EmbeddedTable> tables, double scale, bool detailed,
             MusculoskeletalModel& model)
      : scale_(scale), detailed_(detailed), model_(model), p_WB_(neutral_places(model)) {
    for (const char* region : kRegions) {
      const Table table(find_table(tables, fmt::format("landmarks_{}", region)),
                        {"landmark", "bone", "x", "y", "z", "note"});
      for (const TableRow& row : table.rows()) add_landmark(row);
    }
  }

  void read(const TableRow& row, bool left) {
    left_ = left;
    PathElement path;
    path.name = name(row);
    if (!names_.insert(path.name).second) {
      row.fail("slip", "a wire's name that is not taken", path.name, "Name the slip.");
    }
    path.source = row.at();
    const auto words = row.words("path");
    if (words.size() < 2) row.fail("path", "two points or more", row.cell("path"), "Add points.");
    for (const std::string_view word : words) path.points.push_back(point(row, word));
    read_properties(row, path);
    model_.paths.push_back(std::move(path));
  }

  bool wanted(const TableRow& row) const { return is_at_level(row, detailed_); }

  // Where level simplified leaves slips of a muscle out, those that stay take over their force.
  void share_forces(const Table& table) {
    std::map<std::string, std::array<double, 2>> sums;  // simplified, detailed [N]
    for (const TableRow& row : table.rows()) {
      if (row.text("kind") != "muscle") continue;
      auto& sum = sums[row.text("muscle")];
      for (const bool detailed : {false, true}) {
        if (is_at_level(row, detailed)) sum[detailed] += row.number("force");
      }
    }
    if (detailed_) return;
    for (const auto& [muscle, sum] : sums) {
      if (sum[1] > sum[0] && sum[0] > 0.0) force_factors_[muscle] = sum[1] / sum[0];
    }
  }

 private:
  void add_landmark(const TableRow& row) {
    require_side(row, "landmark");
    require_midline(row, "landmark");
    const std::string name = row.text("landmark");
    const int body = find_bone(model_, row, "bone");
    if (!landmarks_.try_emplace(name, Landmark{body, scale_ * row.place()}).second) {
      row.fail("landmark", "a name that is not taken", name, "Rename one of them.");
    }
    if (!is_right(name)) return;
    const int other = model_.find_body(mirrored(row.cell("bone")));
    landmarks_[mirrored(name)] = {other, mirrored(Vector3d(scale_ * row.place()))};
  }

  std::string sided(std::string_view name) const {
    return left_ ? mirrored(name) : std::string(name);
  }

  // muscle_slip, with the side at the end.
  std::string name(const TableRow& row) const {
    const std::string muscle = sided(row.text("muscle"));
    if (row.blank("slip")) return muscle;
    const bool paired = is_right(row.cell("muscle"));
    const std::size_t stem = muscle.size() - (paired ? 2 : 0);
    return fmt::format("{}_{}{}", muscle.substr(0, stem), row.cell("slip"), muscle.substr(stem));
  }

  PathPoint point(const TableRow& row, std::string_view word) const {
    PathPoint point;
    if (word.starts_with('@')) return point_on_virtual_link(row, word);
    point.name = sided(word);
    const auto found = landmarks_.find(point.name);
    if (found == landmarks_.end()) {
      row.fail("path", "landmarks of model/whole_body/landmarks_*.csv", word,
               "Correct the name or add the landmark.");
    }
    point.body = found->second.body;
    point.p_BP = found->second.p_BP;
    return point;
  }

  PathPoint point_on_virtual_link(const TableRow& row, std::string_view word) const {
    PathPoint point;
    const std::size_t colon = word.find(':');
    point.name = sided(word.substr(1, colon == std::string_view::npos ? colon : colon - 1));
    point.body = model_.find_body(point.name);
    if (point.body < 0 || !model_.bodies[static_cast<std::size_t>(point.body)].virtual_link) {
      row.fail("path", "a virtual link of model/whole_body/virtual_links_*.csv, at level detailed",
               word, "Correct the name, the level, or add the virtual link.");
    }
    if (colon == std::string_view::npos) return point;
    const auto p = numbers_between_colons(row, "path", word.substr(colon + 1), 3, 3, -3);
    const Vector3d p_BP = scale_ * Vector3d(p[0], p[1], p[2]);
    point.p_BP = left_ ? mirrored(p_BP) : p_BP;
    return point;
  }

  double neutral_length(const PathElement& path) const {
    double length = 0.0;
    for (std::size_t i = 1; i < path.points.size(); ++i) {
      length += (place(path.points[i]) - place(path.points[i - 1])).norm();
    }
    return length;
  }
  Vector3d place(const PathPoint& point) const {
    return p_WB_[static_cast<std::size_t>(point.body)] + point.p_BP;
  }

  void read_properties(const TableRow& row, PathElement& path) const {
    const double neutral = neutral_length(path);
    if (neutral < scale_ * kShortestPath) {
      row.fail("path", "points 5 mm apart or more", fmt::format("{:.3g} mm", 1e3 * neutral),
               "Correct the landmarks.");
    }
    const std::string kind = row.text("kind");
    if (kind == "muscle") {
      path.kind = PathElement::Kind::kMuscle;
      path.class_name = "Thelen2003Muscle";
      read_muscle(row, neutral, path);
      return;
    }
    if (kind != "tendon" && kind != "ligament") {
      row.fail("kind", "muscle, tendon or ligament", kind, "Correct the kind.");
    }
    path.kind = kind == "tendon" ? PathElement::Kind::kTendon : PathElement::Kind::kLigament;
    path.class_name = kind == "tendon" ? "PathSpring" : "Ligament";
    path.natural_length = neutral * (row.blank("slackness") ? 1.0 : bounded(row, "slackness", 2.0));
  }

  void read_muscle(const TableRow& row, double neutral, PathElement& path) const {
    constexpr double kStrongest = 1e4;  // [N] beyond any published muscle
    const double fibre = bounded(row, "fibre", 1.0);
    const auto factor = force_factors_.find(row.cell("muscle"));
    path.max_isometric_force =
        bounded(row, "force", kStrongest) * (factor == force_factors_.end() ? 1.0 : factor->second);
    path.optimal_fiber_length = fibre * neutral;
    path.tendon_slack_length = (1.0 - fibre) * neutral;
    path.pennation_angle = 0.0;  // the fibres' part of the path lies along it
    path.natural_length = path.tendon_slack_length + kLongestFiber * path.optimal_fiber_length;
  }

  static double bounded(const TableRow& row, std::string_view column, double high) {
    const double value = row.number(column);
    if (!(value > 0.0 && value <= high)) {
      row.fail(column, fmt::format("a number above 0, at most {}", high), row.cell(column),
               "Correct the number.");
    }
    return value;
  }

  double scale_;
  bool detailed_, left_ = false;
  MusculoskeletalModel& model_;
  std::vector<Vector3d> p_WB_;  // neutral, from the hips
  std::map<std::string, Landmark, std::less<>> landmarks_;
  std::set<std::string, std::less<>> names_;
  std::map<std::string, double, std::less<>> force_factors_;  // by the tables' name of a muscle
};

void add_virtual_link(const TableRow& row, bool left, double scale, MusculoskeletalModel& model) {
  const std::string own = row.text("virtual_link");
  const Vector3d place = scale * row.place();
  Body body;
  body.name = left ? mirrored(own) : own;
  body.virtual_link = true;
  body.source = row.at();
  Joint joint;
  joint.name = body.name + "_joint";
  joint.kind = Joint::Kind::kFree;
  joint.parent = find_bone(model, row, "bone");
  if (left) {
    joint.parent =
        model.find_body(mirrored(model.bodies[static_cast<std::size_t>(joint.parent)].name));
  }
  joint.child = static_cast<int>(model.bodies.size());
  joint.X_PF.p = left ? mirrored(place) : place;
  joint.source = row.at();
  for (const char* motion : {"rx", "ry", "rz", "tx", "ty", "tz"}) {
    Coordinate c;
    c.name = fmt::format("{}_{}", body.name, motion);
    c.joint = static_cast<int>(model.joints.size());
    if (motion[0] == 't') c.motion = Coordinate::Motion::kTranslational;
    c.source = row.at();
    joint.coordinates.push_back(static_cast<int>(model.coordinates.size()));
    model.coordinates.push_back(c);
  }
  model.bodies.push_back(body);
  model.joints.push_back(joint);
}

}  // namespace

void add_virtual_links(std::span<const EmbeddedTable> tables, double scale,
                       MusculoskeletalModel& model) {
  for (const char* region : kRegions) {
    const Table table(find_table(tables, fmt::format("virtual_links_{}", region)),
                      {"virtual_link", "bone", "x", "y", "z", "note"});
    for (const bool left : {false, true}) {
      for (const TableRow& row : table.rows()) {
        require_side(row, "virtual_link");
        require_midline(row, "virtual_link");
        if (!left || is_right(row.cell("virtual_link"))) add_virtual_link(row, left, scale, model);
      }
    }
  }
}

void add_paths(std::span<const EmbeddedTable> tables, double scale, bool detailed,
               MusculoskeletalModel& model) {
  PathReader reader(tables, scale, detailed, model);
  for (const char* region : kRegions) {
    const Table table(find_table(tables, fmt::format("wires_{}", region)),
                      {"muscle", "slip", "kind", "level", "force", "fibre", "path"},
                      {"slackness", "note"});
    reader.share_forces(table);
    for (const bool left : {false, true}) {
      for (const TableRow& row : table.rows()) {
        if (!reader.wanted(row)) continue;
        if (!left || is_right(row.cell("muscle"))) reader.read(row, left);
      }
    }
  }
}

void add_markers(std::span<const EmbeddedTable> tables, double scale, MusculoskeletalModel& model) {
  const Table table(find_table(tables, "markers"), {"marker", "bone", "x", "y", "z", "note"});
  for (const bool left : {false, true}) {
    for (const TableRow& row : table.rows()) {
      const bool paired = is_right(row.cell("bone"));
      Marker marker;
      marker.name = row.text("marker");
      marker.source = row.at();
      marker.body = find_bone(model, row, "bone");
      marker.p_BM = scale * row.place();
      if (paired && !marker.name.starts_with('R')) {
        row.fail("marker", "a name that begins with R, on a bone of the right side", marker.name,
                 "Rename it.");
      }
      if (left) {
        if (!paired) continue;
        marker.name[0] = 'L';
        marker.body = model.find_body(mirrored(row.cell("bone")));
        marker.p_BM = mirrored(marker.p_BM);
      }
      model.markers.push_back(marker);
    }
  }
}

}  // namespace sinew::anatomy
