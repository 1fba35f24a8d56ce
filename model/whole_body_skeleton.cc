#include "model/whole_body_skeleton.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace sinew::anatomy {
namespace {

using Eigen::Vector3d;

constexpr double kDegree = std::numbers::pi / 180.0;
constexpr int kMillimetres = -3;

// Reads a row of joints.csv and appends the joint; the left side's if `left`.
class JointReader {
 public:
  JointReader(const TableRow& row, bool left, double scale, MusculoskeletalModel& model)
      : row_(row), left_(left), scale_(scale), model_(model) {}

  void read() {
    joint_.name = named(row_.text("joint"));
    joint_.source = row_.at();
    joint_.kind = Joint::Kind::kCustom;
    joint_.parent = model_.find_body(named(row_.text("parent")));
    if (joint_.parent < 0) {
      row_.fail("parent", "ground or the bone of an earlier row", row_.cell("parent"),
                "Correct the name or the order of the rows.");
    }
    joint_.child = static_cast<int>(model_.bodies.size());
    joint_.X_PF.p = scale_ * sided(row_.place());
    const std::string name = named(row_.text("bone"));
    if (model_.find_body(name) >= 0) {
      row_.fail("bone", "a name that is not taken", name, "Rename one of the bones.");
    }
    Body& body = model_.bodies.emplace_back();
    body.name = name;
    body.source = row_.at();
    read_coordinates();
    read_coupling();
    model_.joints.push_back(joint_);
  }

 private:
  std::string named(std::string_view name) const {
    return left_ ? mirrored(name) : std::string(name);
  }
  Vector3d sided(const Vector3d& p) const { return left_ ? mirrored(p) : p; }
  static bool is_shift(std::string_view axis) { return axis == "x" || axis == "y" || axis == "z"; }

  void read_coordinates() {
    const auto names = row_.words("coordinates"), axes = row_.words("axes"),
               ranges = row_.words("ranges");
    const std::string count = fmt::format("as many as coordinates, {}", names.size());
    if (axes.size() != names.size()) {
      row_.fail("axes", count, row_.cell("axes"), "Give each coordinate an axis.");
    }
    if (ranges.size() != names.size()) {
      row_.fail("ranges", count, row_.cell("ranges"), "Give each coordinate a range.");
    }
    std::vector<Vector3d> turns;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const bool shifts = is_shift(axes[i]);
      const int index = add_coordinate(names[i], ranges[i], shifts);
      if (shifts) {
        const int k = axes[i][0] - 'x';
        set_axis(3 + static_cast<std::size_t>(k), sided(Vector3d::Unit(k)), index);
      } else {
        if (turns.size() == 3) {
          row_.fail("axes", "at most three turns", row_.cell("axes"), "Split the joint.");
        }
        // The axis of a turn is a pseudovector: mirrored, it also changes its sign.
        const Vector3d axis = direction(row_, "axes", axes[i]);
        turns.push_back(left_ ? Vector3d(-mirrored(axis)) : axis);
        set_axis(turns.size() - 1, turns.back(), index);
      }
    }
    fill_axes(turns);
  }

  int add_coordinate(std::string_view name, std::string_view range, bool shifts) {
    const std::vector<double> numbers =
        numbers_between_colons(row_, "ranges", range, 2, 3, shifts ? kMillimetres : 0);
    const double unit = shifts ? scale_ : kDegree;
    Coordinate c;
    c.name = named(name);
    c.source = row_.at();
    c.joint = static_cast<int>(model_.joints.size());
    if (shifts) c.motion = Coordinate::Motion::kTranslational;
    c.range_min = unit * numbers.front();
    c.range_max = unit * numbers.back();
    c.default_value = numbers.size() == 3 ? unit * numbers[1] : 0.0;
    if (!(c.range_min <= c.default_value && c.default_value <= c.range_max)) {
      row_.fail("ranges", "low:high around the default, 0 unless given between them", range,
                "Correct the range.");
    }
    // The root's ranges say what is usual, and what is coupled follows.
    c.clamped = joint_.parent != 0 && row_.blank("coupling");
    const int index = static_cast<int>(model_.coordinates.size());
    joint_.coordinates.push_back(index);
    model_.coordinates.push_back(c);
    return index;
  }

  void set_axis(std::size_t i, const Vector3d& axis, int coordinate) {
    if (joint_.axes[i].coordinate >= 0) {
      row_.fail("axes", "each shift once", row_.cell("axes"), "Remove one of them.");
    }
    joint_.axes[i].axis = axis;
    joint_.axes[i].coordinate = coordinate;
    joint_.axes[i].function = {LinearFunction{}};
  }

  // Axes of turns that nothing drives: independent of the others, which Simbody asks for.
  void fill_axes(std::vector<Vector3d>& turns) {
    while (turns.size() < 3) {
      Vector3d next = Vector3d::UnitX();
      if (turns.size() == 1) {
        int least = 0;
        turns[0].cwiseAbs().minCoeff(&least);
        next = Vector3d::Unit(least);
      } else if (turns.size() == 2) {
        next = turns[0].cross(turns[1]).normalized();
      }
      joint_.axes[turns.size()].axis = next;
      turns.push_back(next);
    }
    for (int k = 0; k < 3; ++k) {
      TransformAxis& shift = joint_.axes[3 + static_cast<std::size_t>(k)];
      if (shift.coordinate < 0) shift.axis = Vector3d::Unit(k);
    }
  }

  void read_coupling() {
    if (row_.blank("coupling")) return;
    const std::string_view cell = row_.cell("coupling");
    const std::size_t colon = cell.find(':');
    const int independent = colon == std::string_view::npos
                                ? -1
                                : model_.find_coordinate(named(cell.substr(colon + 1)));
    if (independent < 0 || joint_.coordinates.size() != 1) {
      row_.fail("coupling", "slope:coordinate, of an earlier row, for a joint of one coordinate",
                cell, "Correct the coupling.");
    }
    CoordinateCoupler coupler;
    coupler.name = joint_.name + "_coupler";
    coupler.dependent = joint_.coordinates[0];
    coupler.independent = independent;
    const double slope = numbers_between_colons(row_, "coupling", cell.substr(0, colon), 1, 1)[0];
    coupler.function = {LinearFunction{slope, 0.0}};
    coupler.source = row_.at();
    model_.couplers.push_back(coupler);
  }

  const TableRow& row_;
  bool left_;
  double scale_;
  MusculoskeletalModel& model_;
  Joint joint_;
};

}  // namespace

void add_bones(std::span<const EmbeddedTable> tables, double scale, MusculoskeletalModel& model) {
  const Table table(find_table(tables, "joints"), {"bone", "parent", "x", "y", "z", "coordinates",
                                                   "axes", "ranges", "joint", "coupling"});
  model.bodies.emplace_back().name = "ground";
  for (const bool left : {false, true}) {
    for (const TableRow& row : table.rows()) {
      if (!left || is_right(row.cell("bone"))) JointReader(row, left, scale, model).read();
    }
  }
}

std::vector<Vector3d> neutral_places(const MusculoskeletalModel& model) {
  std::vector<Vector3d> places(model.bodies.size(), Vector3d::Zero());
  for (const Joint& joint : model.joints) {
    places[static_cast<std::size_t>(joint.child)] =
        places[static_cast<std::size_t>(joint.parent)] + joint.X_PF.p;
  }
  return places;
}

int find_bone(const MusculoskeletalModel& model, const TableRow& row, std::string_view column) {
  const int body = model.find_body(row.text(column));
  if (body <= 0) {
    row.fail(column, "a bone of model/whole_body/joints.csv", row.cell(column),
             "Correct the name.");
  }
  return body;
}

Vector3d direction(const TableRow& row, std::string_view column, std::string_view word) {
  const bool negative = word.starts_with('-');
  const std::string_view letter = word.substr(negative ? 1 : 0);
  if (letter == "X" || letter == "Y" || letter == "Z") {
    return (negative ? -1.0 : 1.0) * Vector3d::Unit(letter[0] - 'X');
  }
  if (word.find(':') == std::string_view::npos) {
    row.fail(column, "X, Y, Z, -X, -Y, -Z or three numbers joined by ':'", word,
             "Correct the axis.");
  }
  const std::vector<double> c = numbers_between_colons(row, column, word, 3, 3);
  const Vector3d axis(c[0], c[1], c[2]);
  if (axis.norm() == 0.0) row.fail(column, "an axis that has a direction", word, "Correct it.");
  return axis;
}

}  // namespace sinew::anatomy
