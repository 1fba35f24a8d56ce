#include "model/whole_body_masses.h"

#include <fmt/format.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <vector>

#include "model/whole_body_skeleton.h"

namespace sinew::anatomy {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// A third at least keeps the slices of the trunk from being thinner than vertebrae are.
constexpr double kOwnPart = 0.3;
constexpr double kShareTolerance = 1e-9;  // shares are typed with few digits

// In the neutral pose, in the world's axes, from the hips.
struct MassProperties {
  double mass = 0.0;
  Vector3d centre = Vector3d::Zero();
  Matrix3d inertia = Matrix3d::Zero();  // about the centre
};

struct BoneShare {
  const TableRow* row = nullptr;
  int body = -1;
  bool left = false;
};

struct Segment {
  std::string name;
  MassProperties whole;
  std::vector<BoneShare> shares;
};

Matrix3d point_inertia(double mass, const Vector3d& p) {
  return mass * (p.squaredNorm() * Matrix3d::Identity() - p * p.transpose());
}

// ∫ x xᵀ dm of an inertia, and back: J = ½ tr(I) 1 − I, I = tr(J) 1 − J.
Matrix3d second_moment(const Matrix3d& inertia) {
  return 0.5 * inertia.trace() * Matrix3d::Identity() - inertia;
}

class MassReader {
 public:
  MassReader(std::span<const EmbeddedTable> tables, const MassOptions& options,
             MusculoskeletalModel& model)
      : segments_(find_table(tables, "segments"),
                  {"name", "sex", "mass_percent", "length_mm", "centre_percent",
                   "r_sagittal_percent", "r_transverse_percent", "r_longitudinal_percent"}),
        places_(find_table(tables, "segment_places"),
                {"segment", "bone", "x", "y", "z", "along", "sagittal"}),
        bones_(find_table(tables, "bones"),
               {"bone", "segment", "share", "x", "y", "z", "size_x", "size_y", "size_z"}),
        options_(options),
        model_(model),
        p_WB_(neutral_places(model)) {}

  void read() {
    percent_sum_ = 0.0;
    for (const TableRow& place : places_.rows()) {
      percent_sum_ += segment_row(place).number("mass_percent") * sides(place);
    }
    for (const TableRow& place : places_.rows()) {
      for (const bool left : {false, true}) {
        if (left && sides(place) == 1) continue;
        Segment segment = read_segment(place, left);
        share_out(segment, place);
      }
    }
    for (std::size_t b = 1; b < model_.bodies.size(); ++b) {
      const Body& body = model_.bodies[b];
      if (body.mass > 0.0) continue;
      throw InputError(body.source, {fmt::format("bone '{}' has no mass", body.name),
                                     "a row in model/whole_body/bones.csv", "", "Add the row."});
    }
  }

 private:
  static int sides(const TableRow& place) { return is_right(place.cell("bone")) ? 2 : 1; }

  // The row of the place's segment, of the wanted sex.
  const TableRow& segment_row(const TableRow& place) const {
    return segment_row(place, options_.female ? "female" : "male");
  }
  const TableRow& segment_row(const TableRow& place, std::string_view sex) const {
    for (const TableRow& row : segments_.rows()) {
      if (row.cell("name") == place.cell("segment") && row.cell("sex") == sex) return row;
    }
    place.fail("segment", fmt::format("a {} segment of model/whole_body/segments.csv", sex),
               place.cell("segment"), "Correct the name or add the row.");
  }

  Segment read_segment(const TableRow& place, bool left) {
    const TableRow& row = segment_row(place);
    constexpr double kTableHeight = 1.80, kSourceHeight = 1.741;  // [m]
    const double length = options_.scale * kTableHeight / kSourceHeight *
                          segment_row(place, "male").number("length_mm", -3);
    const auto part = [&](const char* column) { return row.number(column, -2); };
    const Vector3d along = direction(place, "along", place.cell("along"));
    const Vector3d sagittal = direction(place, "sagittal", place.cell("sagittal"));
    if (std::abs(along.dot(sagittal)) > 0.0) {
      place.fail("sagittal", "an axis square to 'along'", place.cell("sagittal"), "Correct it.");
    }
    const Vector3d radii = part("r_longitudinal_percent") * along.cwiseAbs() +
                           part("r_sagittal_percent") * sagittal.cwiseAbs() +
                           part("r_transverse_percent") * along.cross(sagittal).cwiseAbs();
    const int bone = find_bone(model_, place, "bone");
    const Vector3d centre = p_WB_[static_cast<std::size_t>(bone)] + options_.scale * place.place() +
                            part("centre_percent") * length * along;
    Segment segment;
    segment.name = place.text("segment");
    segment.whole.mass = options_.mass * row.number("mass_percent") / percent_sum_;
    segment.whole.centre = left ? mirrored(centre) : centre;
    segment.whole.inertia =
        (segment.whole.mass * (length * radii).array().square()).matrix().asDiagonal();
    find_shares(segment, sides(place) == 2, left);
    return segment;
  }

  // Of a segment of one side the bones of that side, of one of the midline all.
  void find_shares(Segment& segment, bool paired, bool left) {
    for (const TableRow& row : bones_.rows()) {
      if (row.cell("segment") != segment.name) continue;
      const int bone = find_bone(model_, row, "bone");
      const bool right = is_right(row.cell("bone"));
      if (!(paired && left)) segment.shares.push_back({&row, bone, false});
      if (right && (left || !paired)) {
        const int other = model_.find_body(mirrored(row.cell("bone")));
        segment.shares.push_back({&row, other, true});
      }
    }
  }

  Vector3d place(const BoneShare& share, const Vector3d& p_B) const {
    return p_WB_[static_cast<std::size_t>(share.body)] +
           options_.scale * (share.left ? mirrored(p_B) : p_B);
  }

  void share_out(const Segment& segment, const TableRow& place_row) {
    double sum = 0.0;
    const BoneShare* rest = nullptr;
    for (const BoneShare& share : segment.shares) {
      if (share.row->cell("share") == "rest") {
        if (rest != nullptr) share.row->fail("share", "one rest", "another", "Give it a number.");
        rest = &share;
      } else {
        sum += positive_share(share);
      }
    }
    const bool good = rest != nullptr ? sum < 1.0 : std::abs(sum - 1.0) <= kShareTolerance;
    if (!good) {
      const TableRow& row = segment.shares.empty() ? place_row : *segment.shares[0].row;
      row.fail("segment",
               rest != nullptr ? "shares in model/whole_body/bones.csv below 1 in sum"
                               : "shares in model/whole_body/bones.csv that add up to 1",
               fmt::format("{:.9g} for {}", sum, segment.name), "Correct the shares.");
    }
    rest != nullptr ? leave_rest(segment, *rest) : spread(segment, sum);
  }

  static double positive_share(const BoneShare& share) {
    const double value = share.row->number("share");
    if (!(value > 0.0)) {
      share.row->fail("share", "'rest' or a positive number", share.row->cell("share"),
                      "Correct the share.");
    }
    return value;
  }

  void leave_rest(const Segment& segment, const BoneShare& rest) {
    MassProperties left = segment.whole;
    Vector3d moment = left.mass * left.centre;
    Matrix3d about_origin = left.inertia + point_inertia(left.mass, left.centre);
    for (const BoneShare& share : segment.shares) {
      if (&share == &rest) continue;
      MassProperties box;
      box.mass = positive_share(share) * segment.whole.mass;
      box.centre = place(share, share.row->place());
      const Vector3d size = options_.scale * share.row->place({"size_x", "size_y", "size_z"});
      const Vector3d squares = size.array().square();
      box.inertia = (box.mass / 12.0 * (Vector3d::Constant(squares.sum()) - squares)).asDiagonal();
      give(share, box);
      left.mass -= box.mass;
      moment -= box.mass * box.centre;
      about_origin -= box.inertia + point_inertia(box.mass, box.centre);
    }
    left.centre = moment / left.mass;
    left.inertia = about_origin - point_inertia(left.mass, left.centre);
    const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(second_moment(left.inertia));
    if (solver.eigenvalues().minCoeff() <= 0.0) {
      rest.row->fail("share", "others that leave an inertia which a body can have", "rest",
                     "Make the others smaller or move them inward.");
    }
    give(rest, left);
  }

  void spread(const Segment& segment, double sum) {
    const MassProperties& whole = segment.whole;
    Vector3d mean = Vector3d::Zero();
    for (const BoneShare& share : segment.shares) {
      mean += positive_share(share) / sum * place(share, share.row->place());
    }
    Matrix3d points = Matrix3d::Zero();  // second moment of the bones' masses as points
    for (const BoneShare& share : segment.shares) {
      const Vector3d r = place(share, share.row->place()) - mean;
      points += positive_share(share) / sum * whole.mass * r * r.transpose();
    }
    // The largest part of the segment's second moment that the points have in any direction.
    const Matrix3d moment = second_moment(whole.inertia);
    const Eigen::GeneralizedSelfAdjointEigenSolver<Matrix3d> solver(points, moment,
                                                                    Eigen::EigenvaluesOnly);
    const double part = solver.eigenvalues().maxCoeff();
    const double k = part > 1.0 - kOwnPart ? std::sqrt((1.0 - kOwnPart) / part) : 1.0;
    const Matrix3d own = moment - k * k * points;
    for (const BoneShare& share : segment.shares) {
      const double s = positive_share(share) / sum;
      const Vector3d r = place(share, share.row->place()) - mean;
      give(share,
           {s * whole.mass, whole.centre + k * r, s * (own.trace() * Matrix3d::Identity() - own)});
    }
  }

  void give(const BoneShare& share, const MassProperties& properties) {
    Body& body = model_.bodies[static_cast<std::size_t>(share.body)];
    if (body.mass > 0.0) {
      share.row->fail("bone", "each bone once", body.name, "Remove one of the rows.");
    }
    body.mass = properties.mass;
    body.p_BCm = properties.centre - p_WB_[static_cast<std::size_t>(share.body)];
    body.I_BCm = 0.5 * (properties.inertia + properties.inertia.transpose());
  }

  Table segments_, places_, bones_;
  MassOptions options_;
  MusculoskeletalModel& model_;
  std::vector<Vector3d> p_WB_;  // neutral, from the hips
  double percent_sum_ = 0.0;
};

}  // namespace

void set_masses(std::span<const EmbeddedTable> tables, const MassOptions& options,
                MusculoskeletalModel& model) {
  MassReader(tables, options, model).read();
}

}  // namespace sinew::anatomy
