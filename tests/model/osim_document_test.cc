#include "model/osim_document.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "model/kinematic_tree.h"
#include "model/osim_file.h"
#include "tests/data/test_files.h"
#include "tests/model/same_model.h"
#include "tests/model/shared_models.h"

namespace sinew {
namespace {

using Eigen::Vector3d;
using Json = nlohmann::json;

// Two bodies with something of everything that the description does not hold.
const std::string kLeg = R"(<?xml version="1.0" encoding="UTF-8"?>
<!-- by hand -->
<OpenSimDocument Version="40000">
  <Model name="leg">
    <Ground name="ground"/>
    <gravity>0 -9.8 0</gravity>
    <BodySet><objects>
      <Body name="thigh">
        <!--kilograms-->
        <mass>8</mass><mass_center>0 -0.2 0</mass_center><inertia>0.1 0.03 0.1 0 0 0</inertia>
        <attached_geometry><Mesh name="bone"><scale_factors>1 2 1</scale_factors></Mesh></attached_geometry>
        <WrapObjectSet><objects><WrapCylinder name="knee">
          <xyz_body_rotation>0 1.5707963267948966 0</xyz_body_rotation>
          <translation>0.01 -0.4 0</translation><radius>0.02</radius><length>0.1</length>
        </WrapCylinder></objects></WrapObjectSet>
        <components><PhysicalOffsetFrame name="pad"><socket_parent>..</socket_parent><translation>0.1 -0.1 0.2</translation></PhysicalOffsetFrame></components>
      </Body>
      <Body name="shank"><mass>4</mass><mass_center>0 -0.2 0</mass_center><inertia>0.05 0.01 0.05 0 0 0</inertia></Body>
    </objects></BodySet>
    <JointSet><objects>
      <PinJoint name="hip"><socket_parent_frame>/ground</socket_parent_frame><socket_child_frame>/bodyset/thigh</socket_child_frame><coordinates><Coordinate name="hip"/></coordinates></PinJoint>
      <PinJoint name="knee"><socket_parent_frame>thigh_offset</socket_parent_frame><socket_child_frame>/bodyset/shank</socket_child_frame><coordinates><Coordinate name="knee"/></coordinates>
        <frames><PhysicalOffsetFrame name="thigh_offset"><socket_parent>/bodyset/thigh</socket_parent><translation>0 -0.4 0</translation></PhysicalOffsetFrame></frames></PinJoint>
    </objects></JointSet>
    <ControllerSet><objects><PrescribedController name="brain"><actuator_list>all</actuator_list></PrescribedController></objects></ControllerSet>
    <ForceSet><objects>
      <Thelen2003Muscle name="vastus"><optimal_fiber_length>0.1</optimal_fiber_length><tendon_slack_length>0.2</tendon_slack_length><max_isometric_force>1000</max_isometric_force>
        <GeometryPath><PathPointSet><objects>
          <PathPoint name="a"><socket_parent_frame>/bodyset/thigh</socket_parent_frame><location>0 -0.1 0</location></PathPoint>
          <PathPoint name="b"><socket_parent_frame>/bodyset/shank</socket_parent_frame><location>0 -0.1 0</location></PathPoint>
        </objects></PathPointSet></GeometryPath></Thelen2003Muscle>
    </objects></ForceSet>
    <ContactGeometrySet><objects><ContactSphere name="heel"><socket_frame>/bodyset/shank</socket_frame><location>0 -0.4 0</location><radius>0.05</radius></ContactSphere></objects></ContactGeometrySet>
    <MarkerSet><objects>
      <Marker name="KNEE"><socket_parent_frame>/bodyset/thigh</socket_parent_frame><location>0 -0.4 0.05</location></Marker>
      <Marker name="PAD"><socket_parent_frame>/bodyset/thigh/pad</socket_parent_frame><location>0.01 0 0</location><fixed>true</fixed></Marker>
    </objects></MarkerSet>
  </Model>
</OpenSimDocument>
)";

ScaleFactors leg_factors(const OsimDocument& leg) {
  ScaleFactors factors(leg.model());
  factors.of_body[1] = {1.1, 1.2, 1.3};
  factors.of_body[2] = {0.9, 0.8, 0.7};
  return factors;
}

TEST(OsimDocument, KeepsWhatIsNotChangedToTheByte) {
  OsimDocument leg("leg.osim", kLeg);
  EXPECT_EQ(leg.to_string(), kLeg);
  leg.scale(ScaleFactors(leg.model()));
  EXPECT_EQ(leg.to_string(), kLeg);
  leg.set_markers(leg.model().markers);
  EXPECT_EQ(leg.to_string(), kLeg);
}

TEST(OsimDocument, ScalesAlsoWhatTheDescriptionDoesNotHold) {
  OsimDocument leg("leg.osim", kLeg);
  const std::vector<Warning> warnings = leg.scale(leg_factors(leg), {24.0, true});
  EXPECT_EQ(to_text(warnings),
            "33: 1 <ContactSphere> stay as they are: OpenSim does not scale them either (first: "
            "'heel')\n");
  const XmlFile xml("scaled", leg.to_string());
  const pugi::xml_node model = xml.root().child("Model");
  const pugi::xml_node thigh = model.child("BodySet").child("objects").child("Body");
  EXPECT_EQ(xml.vector3(thigh.child("attached_geometry").child("Mesh"), "scale_factors"),
            Vector3d(1.1, 2.4, 1.3));
  const pugi::xml_node wrap = thigh.child("WrapObjectSet").child("objects").child("WrapCylinder");
  EXPECT_LT((*xml.vector3(wrap, "translation") - Vector3d(0.011, -0.48, 0)).norm(), 1e-16);
  // Its z axis is the body's x axis, its x axis the body's −z axis.
  EXPECT_NEAR(*xml.number(wrap, "length"), 0.11, 1e-15);
  EXPECT_NEAR(*xml.number(wrap, "radius"), 0.02 * 0.5 * (1.3 + 1.2), 1e-15);
  EXPECT_EQ(xml.text(thigh.child("mass")), "16");
  EXPECT_NE(leg.to_string().find("<!--kilograms-->"), std::string::npos);
  EXPECT_NE(leg.to_string().find("<PrescribedController name=\"brain\">"), std::string::npos);
  const MusculoskeletalModel& scaled = leg.model();
  EXPECT_LT((scaled.joints[1].X_PF.p - Vector3d(0, -0.48, 0)).norm(), 1e-16);
  EXPECT_LT((scaled.markers[1].p_BM - Vector3d(1.1 * 0.11, -0.12, 0.26)).norm(), 1e-16);
  // The path grows from 0.4 to 1.2·0.3 + 0.8·0.1.
  EXPECT_NEAR(scaled.paths[0].optimal_fiber_length, 0.1 * 0.44 / 0.4, 1e-15);
  EXPECT_NEAR(scaled.paths[0].tendon_slack_length, 0.2 * 0.44 / 0.4, 1e-15);
}

TEST(OsimDocument, MovesAndRemovesMarkers) {
  OsimDocument leg("leg.osim", kLeg);
  std::vector<Marker> markers = leg.model().markers;
  markers[1].p_BM += Vector3d(0, 0.5, 0);
  markers.erase(markers.begin());
  leg.set_markers(markers);
  ASSERT_EQ(leg.model().markers.size(), 1u);
  EXPECT_LT((leg.model().markers[0].p_BM - markers[0].p_BM).norm(), 1e-15);
  EXPECT_TRUE(leg.model().markers[0].fixed);
  EXPECT_EQ(leg.to_string().find("KNEE"), std::string::npos);
}

TEST(OsimDocument, TakesMarkersOfEitherVersion) {
  const TemporaryFolder folder;
  const auto old = folder.write("old.xml",
                                "<OpenSimDocument Version=\"20302\"><MarkerSet><objects>\n"
                                "<Marker name=\"KNEE\"><body> shank </body><location> 0 0 0.06 "
                                "</location><fixed> true </fixed></Marker>\n"
                                "</objects></MarkerSet></OpenSimDocument>");
  OsimDocument leg("leg.osim", kLeg);
  leg.merge_markers(old);
  ASSERT_EQ(leg.model().markers.size(), 2u);
  const Marker& knee = leg.model().markers[1];
  EXPECT_EQ(knee.name, "KNEE");
  EXPECT_EQ(knee.body, 2);
  EXPECT_EQ(knee.p_BM, Vector3d(0, 0, 0.06));
  EXPECT_TRUE(knee.fixed);
  // What it writes it reads again.
  const auto written = folder.write("new.xml", write_marker_set(leg.model()));
  OsimDocument again("leg.osim", kLeg);
  again.merge_markers(written);
  expect_same(again.model().markers, leg.model().markers);
}

TEST(OsimDocument, RefusesUnusableMarkerSets) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& markers) {
    return error_of(folder.path(), [&] {
      OsimDocument("leg.osim", kLeg).merge_markers(folder.write("m.xml", markers));
    });
  };
  EXPECT_EQ(refusal("<OpenSimDocument Version=\"40000\"><ScaleSet/></OpenSimDocument>"),
            "m.xml:1: holds no markers; expected an OpenSimDocument with a <MarkerSet>, found "
            "<OpenSimDocument> with <ScaleSet>. Name a file with a marker set.");
  EXPECT_EQ(refusal("<MarkerSet><objects>\n<Marker name=\"A\"><body>foot</body></Marker>"
                    "</objects></MarkerSet>"),
            "m.xml:2: marker 'A' is on a body that model 'leg' does not have; expected the name of "
            "a body of the model, found foot. Correct the name, or remove the marker.");
  EXPECT_EQ(refusal("<MarkerSet><objects>\n<Marker name=\"A\"><body>shank</body><location>nan 0 "
                    "0</location></Marker></objects></MarkerSet>"),
            "m.xml:2: the location of marker 'A' is not finite; expected three finite numbers, "
            "found nan 0 0. Correct the location.");
}

ScaleFactors random_factors(const MusculoskeletalModel& model, unsigned seed) {
  ScaleFactors factors(model);
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> value(0.8, 1.25);
  for (std::size_t b = 1; b < factors.of_body.size(); ++b) {
    for (double& f : factors.of_body[b]) f = value(random);
  }
  return factors;
}

void expect_near(const MusculoskeletalModel& a, const MusculoskeletalModel& b) {
  for (std::size_t i = 0; i < a.bodies.size(); ++i) {
    EXPECT_NEAR(a.bodies[i].mass, b.bodies[i].mass, 1e-12 * a.bodies[i].mass);
    EXPECT_LT((a.bodies[i].p_BCm - b.bodies[i].p_BCm).norm(), 1e-14);
  }
  for (std::size_t i = 0; i < a.joints.size(); ++i) {
    EXPECT_LT((a.joints[i].X_PF.p - b.joints[i].X_PF.p).norm(), 1e-13) << a.joints[i].name;
    EXPECT_LT((a.joints[i].X_BM.p - b.joints[i].X_BM.p).norm(), 1e-13) << a.joints[i].name;
    for (std::size_t k = 0; k < 6; ++k) {
      const double x = 0.3;
      EXPECT_NEAR(CompiledFunction(a.joints[i].axes[k].function).value(x),
                  CompiledFunction(b.joints[i].axes[k].function).value(x), 1e-13);
    }
  }
  for (std::size_t i = 0; i < a.markers.size(); ++i) {
    EXPECT_LT((a.markers[i].p_BM - b.markers[i].p_BM).norm(), 1e-13) << a.markers[i].name;
  }
  for (std::size_t i = 0; i < a.paths.size(); ++i) {
    if (std::isnan(a.paths[i].natural_length)) continue;
    EXPECT_NEAR(a.paths[i].natural_length, b.paths[i].natural_length, 1e-12) << a.paths[i].name;
  }
}

// Two ways to the same model: the document edited and read again, and the description scaled.
TEST(OsimDocument, AgreesWithScaleModelOnPublishedModels) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  unsigned seed = 0;
  for (const std::filesystem::path& path : shared_models()) {
    // Its frames stand turned on other frames, where OpenSim scales along each frame's parent.
    if (has_no_bodies(path) || path.filename() == "StationDefinedFrames_Advanced.osim") continue;
    SCOPED_TRACE(path.string());
    OsimDocument document(path);
    const MusculoskeletalModel before = document.model();
    if (before.total_mass() == 0.0) continue;
    const ScaleFactors factors = random_factors(before, ++seed);
    document.scale(factors, {70.0, seed % 2 == 0});
    expect_near(document.model(), scale_model(before, factors, {70.0, seed % 2 == 0}));
  }
}

Vector3d vector3(const Json& json) {
  return {json[0].get<double>(), json[1].get<double>(), json[2].get<double>()};
}

struct Golden {
  Json expected;
  OsimDocument document;

  explicit Golden(const std::string& file, const Json& json)
      : expected(json), document(kSharedData / file) {
    ScaleFactors factors(document.model());
    for (const auto& [body, f] : expected["factors"].items()) {
      factors.of_body[static_cast<std::size_t>(document.model().find_body(body))] = vector3(f);
    }
    document.scale(factors, {expected["mass"].get<double>(),
                             expected["preserve_mass_distribution"].get<bool>()});
  }

  void check_bodies() const {
    const XmlFile xml("scaled", document.to_string());
    for (const auto& [name, json] : expected["bodies"].items()) {
      SCOPED_TRACE(name);
      const Body& body =
          document.model().bodies[static_cast<std::size_t>(document.model().find_body(name))];
      EXPECT_NEAR(body.mass, json["mass"].get<double>(), 1e-12);
      EXPECT_LT((body.p_BCm - vector3(json["mass_center"])).norm(), 1e-14);
    }
  }

  void check_inertias() const {
    const XmlFile xml("scaled", document.to_string());
    for (const pugi::xml_node node :
         xml.root().child("Model").child("BodySet").child("objects").children("Body")) {
      const std::string name = node.attribute("name").value();
      if (!node.child("inertia") || !expected["bodies"].contains(name)) continue;
      const std::vector<double> ours = xml.numbers(node.child("inertia"));
      for (std::size_t i = 0; i < 6; ++i) {
        EXPECT_NEAR(ours[i], expected["bodies"][name]["inertia"][i].get<double>(), 1e-12) << name;
      }
    }
  }

  static void check_wrap(const XmlFile& xml, pugi::xml_node wrap, const Json& json) {
    EXPECT_LT((*xml.vector3(wrap, "translation") - vector3(json["translation"])).norm(), 1e-13);
    for (const char* size : {"radius", "length", "inner_radius", "outer_radius"}) {
      // OpenSim prints six digits of these to its scripts.
      if (json.contains(size)) {
        EXPECT_NEAR(*xml.number(wrap, size), json[size].get<double>(),
                    1e-5 * json[size].get<double>())
            << size;
      }
    }
    if (json.contains("dimensions")) {
      EXPECT_LT((*xml.vector3(wrap, "dimensions") - vector3(json["dimensions"])).norm(), 1e-13);
    }
  }

  int check_wraps() const {
    int checked = 0;
    const XmlFile xml("scaled", document.to_string());
    for (const pugi::xml_node body :
         xml.root().child("Model").child("BodySet").child("objects").children("Body")) {
      const std::string name = body.attribute("name").value();
      if (!expected["wrap_objects"].contains(name)) continue;
      for (const pugi::xml_node wrap : body.child("WrapObjectSet").child("objects").children()) {
        if (wrap.type() != pugi::node_element) continue;
        const std::string wrap_name = wrap.attribute("name").value();
        SCOPED_TRACE(name + " " + wrap_name);
        check_wrap(xml, wrap, expected["wrap_objects"][name][wrap_name]);
        ++checked;
      }
    }
    return checked;
  }

  void check_paths() const {
    for (const auto& [name, json] : expected["paths"].items()) {
      SCOPED_TRACE(name);
      const auto& paths = document.model().paths;
      const auto path = std::find_if(paths.begin(), paths.end(),
                                     [&](const PathElement& p) { return p.name == name; });
      ASSERT_NE(path, paths.end());
      for (std::size_t i = 0; i < path->points.size(); ++i) {
        if (path->points[i].kind == PathPoint::Kind::kMoving) continue;
        EXPECT_LT((path->points[i].p_BP - vector3(json["points"][i])).norm(), 1e-12) << i;
      }
      if (json["wraps"].get<int>() > 0) continue;  // their paths are not straight
      const auto near = [&](const char* length, double ours) {
        if (json.contains(length)) {
          EXPECT_NEAR(ours, json[length].get<double>(), 1e-5 * ours) << length;
        }
      };
      near("optimal_fiber_length", path->optimal_fiber_length);
      near("tendon_slack_length", path->tendon_slack_length);
      near("resting_length", path->natural_length);
    }
  }

  void check_places() const {
    const MusculoskeletalModel& model = document.model();
    const KinematicTree tree = compile_tree(model);
    KinematicWorkspace ws(tree);
    for (std::size_t c = 0; c < model.coordinates.size(); ++c) {
      const std::string& name = model.coordinates[c].name;
      const auto joint = static_cast<std::size_t>(model.coordinates[c].joint);
      ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
          expected["coordinates"][model.joints[joint].name + "/" + name.substr(name.find('/') + 1)]
              .get<double>();
    }
    update_poses(tree, ws);
    // OpenSim assembles coupled coordinates to 1e-9, and converts older documents to its present
    // layout with six digits.
    const double tolerance = model.document_version < 30505 ? 1e-6 : 1e-8;
    for (const auto& [name, p] : expected["places"].items()) {
      const auto b = static_cast<std::size_t>(model.find_body(name));
      EXPECT_LT((ws.X_WB[b].p - vector3(p)).norm(), tolerance) << name;
    }
  }
};

TEST(OsimDocument, ScalesAsOpenSim) {
  SINEW_SKIP_WITHOUT_SHARED_DATA();
  const Json golden = Json::parse(std::ifstream("tests/golden/osim_scaled.json"));
  int wraps = 0;
  for (const auto& [file, expected] : golden["models"].items()) {
    SCOPED_TRACE(file);
    const Golden scaled(file, expected);
    scaled.check_bodies();
    scaled.check_inertias();
    wraps += scaled.check_wraps();
    scaled.check_paths();
    scaled.check_places();
  }
  EXPECT_GT(wraps, 50);
}

}  // namespace
}  // namespace sinew
