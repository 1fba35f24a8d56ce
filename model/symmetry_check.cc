#include <fmt/format.h>

#include <array>
#include <cctype>
#include <cmath>
#include <limits>
#include <map>

#include "model/model_check.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Severity = ModelFinding::Severity;

char other_side(char side) {
  switch (side) {
    case 'r':
      return 'l';
    case 'l':
      return 'r';
    case 'R':
      return 'L';
    case 'L':
      return 'R';
    default:
      return '\0';
  }
}

// A side stands by itself between separators, or as the first letter of a marker in capitals.
bool marks_side(const std::string& name, std::size_t i) {
  const auto separates = [&](std::size_t k) {
    return k >= name.size() || name[k] == '_' || name[k] == '.' || name[k] == '-';
  };
  const bool starts = i == 0 || separates(i - 1), ends = separates(i + 1);
  if (starts && ends) return true;
  return i == 0 && name.size() > 2 && std::isupper(static_cast<unsigned char>(name[0])) != 0 &&
         std::isupper(static_cast<unsigned char>(name[1])) != 0;
}

template <typename Items>
std::vector<int> partners_of(const Items& items) {
  std::map<std::string, int> index;
  for (std::size_t i = 0; i < items.size(); ++i) index[items[i].name] = static_cast<int>(i);
  std::vector<int> partners(items.size(), -1);
  for (std::size_t i = 0; i < items.size(); ++i) {
    for (const std::string& name : partner_names(items[i].name)) {
      if (const auto found = index.find(name); found != index.end()) partners[i] = found->second;
    }
  }
  return partners;
}

/// Compares every element with its partner once, and keeps what differs.
class SymmetryCheck {
 public:
  SymmetryCheck(const MusculoskeletalModel& model, const ModelCheckOptions& options)
      : model_(model),
        options_(options),
        body_partner_(partners_of(model.bodies)),
        path_partner_(partners_of(model.paths)),
        marker_partner_(partners_of(model.markers)),
        mirror_(mirror()) {}

  std::vector<ModelFinding> run() {
    each_pair(body_partner_, [&](std::size_t a, std::size_t b) { compare_bodies(a, b); });
    each_pair(path_partner_, [&](std::size_t a, std::size_t b) {
      compare_paths(model_.paths[a], model_.paths[b]);
    });
    each_pair(marker_partner_, [&](std::size_t a, std::size_t b) {
      compare_markers(model_.markers[a], model_.markers[b]);
    });
    report_single(model_.bodies, body_partner_, "body");
    report_single(model_.paths, path_partner_, "path");
    return findings_;
  }

 private:
  template <typename Compare>
  static void each_pair(const std::vector<int>& partners, const Compare& compare) {
    for (std::size_t i = 0; i < partners.size(); ++i) {
      if (partners[i] > static_cast<int>(i)) compare(i, static_cast<std::size_t>(partners[i]));
    }
  }

  // The body that mirrors `body`: its partner, or itself on the midline.
  int mirrored_body(int body) const {
    const int partner = body_partner_[static_cast<std::size_t>(body)];
    return partner < 0 ? body : partner;
  }

  // Signs of the axes; of joints and path points, half of the sum of all distances.
  Vector3d mirror() const {
    std::array<Vector3d, 3> candidates = {Vector3d(1, 1, -1), Vector3d(1, -1, 1),
                                          Vector3d(-1, 1, 1)};
    Vector3d best = candidates[0];
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& signs : candidates) {
      double sum = 0.0;
      each_pair(body_partner_, [&](std::size_t a, std::size_t b) {
        if (a == 0 || b == 0) return;
        const Joint &ja = model_.joints[a - 1], &jb = model_.joints[b - 1];
        sum += (signs.cwiseProduct(ja.X_PF.p) - jb.X_PF.p).norm();
      });
      each_pair(path_partner_, [&](std::size_t a, std::size_t b) {
        const PathElement &pa = model_.paths[a], &pb = model_.paths[b];
        for (std::size_t i = 0; i < std::min(pa.points.size(), pb.points.size()); ++i) {
          sum += (signs.cwiseProduct(pa.points[i].p_BP) - pb.points[i].p_BP).norm();
        }
      });
      if (sum < least) {
        least = sum;
        best = signs;
      }
    }
    return best;
  }

  void add(Severity severity, const std::string& element, const SourceLocation& source,
           std::string text) {
    findings_.push_back({severity, "asymmetry", element, std::move(text), source});
  }

  double off(const Vector3d& a, const Vector3d& b) const {
    return (mirror_.cwiseProduct(a) - b).norm();
  }

  bool differ(double a, double b) const {
    return std::abs(a - b) > options_.relative_tolerance * std::max(std::abs(a), std::abs(b));
  }

  void compare_bodies(std::size_t a, std::size_t b) {
    const Body &ba = model_.bodies[a], &bb = model_.bodies[b];
    const auto report = [&](std::string text) {
      add(Severity::kWarning, ba.name, ba.source, std::move(text));
    };
    if (differ(ba.mass, bb.mass)) {
      report(fmt::format("has {:.6g} kg, '{}' {:.6g} kg", ba.mass, bb.name, bb.mass));
    }
    if (const double d = off(ba.p_BCm, bb.p_BCm); d > options_.mirror_tolerance) {
      report(fmt::format("its mass centre and that of '{}' differ by {:.1f} mm when mirrored",
                         bb.name, 1e3 * d));
    }
    const Eigen::Matrix3d M = mirror_.asDiagonal();
    const double scale = std::max(ba.I_BCm.norm(), bb.I_BCm.norm());
    if ((M * ba.I_BCm * M - bb.I_BCm).norm() > options_.relative_tolerance * scale) {
      report(fmt::format("its inertia and that of '{}' differ when mirrored", bb.name));
    }
    if (a > 0 && b > 0) compare_joints(model_.joints[a - 1], model_.joints[b - 1]);
  }

  void compare_joints(const Joint& a, const Joint& b) {
    const auto report = [&](std::string text) {
      add(Severity::kWarning, a.name, a.source, std::move(text));
    };
    if (a.kind != b.kind || a.coordinates.size() != b.coordinates.size()) {
      report(fmt::format("is of another kind than joint '{}'", b.name));
    }
    if (mirrored_body(a.parent) != b.parent) {
      report(fmt::format("hangs from '{}', joint '{}' from '{}'",
                         model_.bodies[static_cast<std::size_t>(a.parent)].name, b.name,
                         model_.bodies[static_cast<std::size_t>(b.parent)].name));
    }
    const double d = std::max(off(a.X_PF.p, b.X_PF.p), off(a.X_BM.p, b.X_BM.p));
    if (d > options_.mirror_tolerance) {
      report(fmt::format("its place and that of '{}' differ by {:.1f} mm when mirrored", b.name,
                         1e3 * d));
    }
  }

  void compare_paths(const PathElement& a, const PathElement& b) {
    const auto report = [&](std::string text) {
      add(Severity::kWarning, a.name, a.source, std::move(text));
    };
    if (a.points.size() != b.points.size()) {
      report(fmt::format("has {} points, '{}' {}", a.points.size(), b.name, b.points.size()));
      return;
    }
    double worst = 0.0;
    std::size_t where = 0;
    for (std::size_t i = 0; i < a.points.size(); ++i) {
      if (mirrored_body(a.points[i].body) != b.points[i].body) {
        report(fmt::format("its point {} is on '{}', that of '{}' on '{}'", i + 1,
                           model_.bodies[static_cast<std::size_t>(a.points[i].body)].name, b.name,
                           model_.bodies[static_cast<std::size_t>(b.points[i].body)].name));
        return;
      }
      if (const double d = off(a.points[i].p_BP, b.points[i].p_BP); d > worst) {
        worst = d;
        where = i;
      }
    }
    if (worst > options_.mirror_tolerance) {
      report(fmt::format("its point {} and that of '{}' differ by {:.1f} mm when mirrored",
                         where + 1, b.name, 1e3 * worst));
    }
    const auto compare = [&](const char* what, double x, double y) {
      if (std::isnan(x) != std::isnan(y) || differ(x, y)) {
        report(fmt::format("{} {:.6g}, of '{}' {:.6g}", what, x, b.name, y));
      }
    };
    compare("maximum isometric force [N]", a.max_isometric_force, b.max_isometric_force);
    compare("natural length [m]", a.natural_length, b.natural_length);
  }

  void compare_markers(const Marker& a, const Marker& b) {
    if (mirrored_body(a.body) != b.body) {
      add(Severity::kWarning, a.name, a.source,
          fmt::format("is on '{}', '{}' on '{}'",
                      model_.bodies[static_cast<std::size_t>(a.body)].name, b.name,
                      model_.bodies[static_cast<std::size_t>(b.body)].name));
    } else if (const double d = off(a.p_BM, b.p_BM); d > options_.marker_mirror_tolerance) {
      add(Severity::kNote, a.name, a.source,
          fmt::format("its place and that of '{}' differ by {:.1f} mm when mirrored", b.name,
                      1e3 * d));
    }
  }

  // Only where others have partners: a model of one leg is not half a model.
  template <typename Items>
  void report_single(const Items& items, const std::vector<int>& partners, const char* what) {
    bool paired = false;
    for (const int partner : partners) paired = paired || partner >= 0;
    for (std::size_t i = 0; paired && i < items.size(); ++i) {
      const bool sided = !partner_names(items[i].name).empty();
      if (!sided || partners[i] >= 0) continue;
      add(Severity::kWarning, items[i].name, items[i].source,
          fmt::format("this {} has no partner on the other side", what));
    }
  }

  const MusculoskeletalModel& model_;
  const ModelCheckOptions& options_;
  std::vector<int> body_partner_, path_partner_, marker_partner_;
  Vector3d mirror_;
  std::vector<ModelFinding> findings_;
};

}  // namespace

std::vector<std::string> partner_names(const std::string& name) {
  std::vector<std::string> partners;
  for (std::size_t i = 0; i < name.size(); ++i) {
    if (other_side(name[i]) == '\0' || !marks_side(name, i)) continue;
    partners.push_back(name);
    partners.back()[i] = other_side(name[i]);
  }
  return partners;
}

std::vector<ModelFinding> check_symmetry(const MusculoskeletalModel& model,
                                         const ModelCheckOptions& options) {
  return SymmetryCheck(model, options).run();
}

}  // namespace sinew
