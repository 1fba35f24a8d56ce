#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <cmath>
#include <set>

#include "model/osim_reader.h"

namespace sinew::osim {

std::array<double, 6> read_inertia_components(const XmlFile& xml, pugi::xml_node node) {
  std::array<double, 6> components{};
  if (const pugi::xml_node current = node.child("inertia")) {
    const std::vector<double> values = xml.numbers(current);
    if (values.size() != 6) {
      xml.fail(current,
               {fmt::format("<inertia> of body '{}' has the wrong number of values", name_of(node)),
                "6 (xx yy zz xy xz yz)", std::to_string(values.size()), "Give all six."});
    }
    std::copy(values.begin(), values.end(), components.begin());
    return components;
  }
  for (std::size_t i = 0; i < 6; ++i) {
    components[i] = xml.number(node, kOldInertia[i]).value_or(0.0);
  }
  return components;
}

namespace {

// Moments of a real body are positive and none exceeds the sum of the others. Simbody insists on
// it; OpenSim's releases compute with whatever stands in the file. The inertia returned is one that
// Simbody accepts and that leaves the largest moment, which matters most, as it is.
Eigen::Matrix3d nearest_physical(const Eigen::Matrix3d& I) {
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(I);
  Eigen::Vector3d moments = principal.eigenvalues();  // increasing
  if (moments[0] >= 0.0 && moments[0] + moments[1] >= moments[2]) return I;
  moments = moments.cwiseMax(0.0);
  const double missing = std::max(0.0, moments[2] - moments[0] - moments[1]);
  moments.head<2>().array() += 0.5 * missing;
  const Eigen::Matrix3d& R = principal.eigenvectors();
  return R * moments.asDiagonal() * R.transpose();
}

Eigen::Matrix3d read_inertia(Reader& reader, pugi::xml_node node, double mass) {
  const std::array<double, 6> c = read_inertia_components(reader.xml, node);
  Eigen::Matrix3d I;
  I << c[0], c[3], c[4], c[3], c[1], c[5], c[4], c[5], c[2];
  if (!I.allFinite()) {
    reader.xml.fail(node, {fmt::format("the inertia of body '{}' is not finite", name_of(node)),
                           "six finite numbers", "", "Correct the inertia."});
  }
  if (mass == 0.0) {
    if (I.norm() > 0.0) {
      reader.warn(node,
                  fmt::format("body '{}' has inertia but no mass; its inertia is taken as zero",
                              name_of(node)));
    }
    return Eigen::Matrix3d::Zero();
  }
  const Eigen::Matrix3d physical = nearest_physical(I);
  constexpr double kRounding = 1e-5;  // files hold six digits
  if ((physical - I).norm() > kRounding * I.norm()) {
    reader.warn(node, fmt::format("the inertia of body '{}' ({} {} {} {} {} {}) belongs to no real "
                                  "body; the nearest that does ({:.6g} {:.6g} {:.6g} {:.6g} {:.6g} "
                                  "{:.6g}) is used",
                                  name_of(node), c[0], c[1], c[2], c[3], c[4], c[5], physical(0, 0),
                                  physical(1, 1), physical(2, 2), physical(0, 1), physical(0, 2),
                                  physical(1, 2)));
  }
  return physical;
}

Body read_body(Reader& reader, pugi::xml_node node) {
  Body body;
  body.name = name_of(node);
  body.source = reader.xml.location(node);
  body.mass = reader.xml.number(node, "mass").value_or(0.0);
  if (!(body.mass >= 0.0) || !std::isfinite(body.mass)) {
    reader.xml.fail(node.child("mass"),
                    {fmt::format("the mass of body '{}' is unusable", body.name),
                     "0 or more kilograms", fmt::format("{}", body.mass), "Correct the mass."});
  }
  body.p_BCm = reader.xml.vector3(node, "mass_center").value_or(Eigen::Vector3d::Zero());
  body.I_BCm = read_inertia(reader, node, body.mass);
  return body;
}

}  // namespace

void read_bodies(Reader& reader) {
  Body ground;
  ground.name = "ground";
  reader.model.bodies.push_back(ground);
  reader.frames.add_body("ground", 0);
  std::set<std::string> names = {"ground"};
  for (const pugi::xml_node node : set_members(reader.model_node, "BodySet")) {
    if (name_of(node) == "ground") {
      reader.frames.add_frames("ground", node);
      continue;
    }
    if (std::string_view(node.name()) != "Body") {
      reader.xml.fail(node, {fmt::format("<{}> in the BodySet is not supported", node.name()),
                             "<Body>", node.name(), "Replace it by a plain Body."});
    }
    const Body body = read_body(reader, node);
    if (body.name.empty()) {
      reader.xml.fail(node, {"a body has no name", "a name attribute", "", "Name the body."});
    }
    if (!names.insert(body.name).second) {
      reader.xml.fail(node, {fmt::format("two bodies are called '{}'", body.name), "unique names",
                             "", "Rename one of them."});
    }
    reader.frames.add_body(body.name, static_cast<int>(reader.model.bodies.size()));
    reader.frames.add_frames(body.name, node);
    reader.model.bodies.push_back(body);
  }
  if (const pugi::xml_node ground_node = reader.model_node.child("Ground")) {
    reader.frames.add_frames("ground", ground_node);
  }
  reader.frames.add_frames("", reader.model_node);
}

}  // namespace sinew::osim
