#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "model/kinematic_tree.h"
#include "model/path_length.h"
#include "model/whole_body.h"

namespace sinew {
namespace {

using Level = WholeBodyOptions::Level;

constexpr double kDegree = std::numbers::pi / 180.0;

// What a muscle of the right side does by its textbook: Standring S (ed.) (2008) Gray's Anatomy,
// 40th ed., Churchill Livingstone, chapters on the back, neck, trunk, shoulder, arm and hand.
// Coordinates of vertebrae: extension, bending to the right, rotation to the left.
struct Action {
  std::string_view wire, coordinate;
  int sign;
};

constexpr Action kSimplified[] = {
    {"longissimus_lumborum_L1_r", "L3_extension", 1},
    {"longissimus_lumborum_L1_r", "L3_bending", 1},
    {"longissimus_thoracis_T5_whole_r", "T10_extension", 1},
    {"longissimus_thoracis_T5_whole_r", "L4_extension", 1},
    {"iliocostalis_lumborum_rib8_whole_r", "L2_extension", 1},
    {"iliocostalis_lumborum_rib8_whole_r", "L2_bending", 1},
    {"multifidus_lumborum_L2_whole_r", "L4_extension", 1},
    {"multifidus_lumborum_L2_whole_r", "L4_rotation", 1},
    {"spinalis_thoracis_T3_r", "T8_extension", 1},
    {"quadratus_lumborum_ilium_rib12_r", "L3_bending", 1},
    {"rectus_abdominis_inner_r", "L3_extension", -1},
    {"rectus_abdominis_outer_r", "T12_extension", -1},
    {"obliquus_externus_rib9_whole_r", "L3_extension", -1},
    {"obliquus_externus_rib7_whole_r", "L3_rotation", 1},
    {"obliquus_internus_rib9_whole_r", "L3_rotation", -1},
    {"obliquus_internus_rib10_r", "L3_bending", 1},
    {"obliquus_internus_rib10_r", "L3_extension", -1},
    {"obliquus_externus_rib11_r", "L3_bending", 1},
    {"semispinalis_capitis_T3_r", "skull_extension", 1},
    {"semispinalis_capitis_T3_r", "C4_extension", 1},
    {"semispinalis_cervicis_C2_r", "C5_extension", 1},
    {"splenius_capitis_T1_r", "C3_extension", 1},
    {"splenius_capitis_T1_r", "C1_rotation", -1},
    {"splenius_capitis_T1_r", "C4_bending", 1},
    {"sternocleidomastoid_sternal_r", "C6_extension", -1},
    {"sternocleidomastoid_sternal_r", "skull_extension", 1},
    {"sternocleidomastoid_sternal_r", "C1_rotation", 1},
    {"sternocleidomastoid_sternal_r", "C5_bending", 1},
    {"longus_colli_T1_C3_r", "C5_extension", -1},
    {"longus_capitis_C5_r", "skull_extension", -1},
    {"scalenus_anterior_C4_r", "C6_extension", -1},
    {"scalenus_medius_C4_r", "C6_bending", 1},
    {"rectus_capitis_posterior_major_r", "skull_extension", 1},
    {"rectus_capitis_posterior_major_r", "C1_rotation", -1},
    {"obliquus_capitis_inferior_r", "C1_rotation", -1},
    {"obliquus_capitis_superior_r", "skull_extension", 1},
    {"rectus_capitis_lateralis_r", "skull_bending", 1},
    {"rectus_capitis_anterior_r", "skull_extension", -1},
    {"longissimus_capitis_T1_r", "C4_bending", 1},
    {"trapezius_occiput_r", "sc_elevation_r", 1},
    {"trapezius_occiput_r", "C5_extension", 1},
    {"trapezius_C7_r", "sc_protraction_r", -1},
    {"trapezius_C7_r", "sc_elevation_r", 1},
    {"trapezius_T8_whole_r", "ac_upward_r", 1},
    {"trapezius_T8_whole_r", "sc_protraction_r", -1},
    {"levator_scapulae_C2_r", "sc_elevation_r", 1},
    {"levator_scapulae_C2_r", "ac_upward_r", -1},
    {"rhomboideus_major_T3_r", "sc_protraction_r", -1},
    {"rhomboideus_major_T3_r", "ac_upward_r", -1},
    {"serratus_anterior_rib7_r", "ac_upward_r", 1},
    {"serratus_anterior_rib5_r", "sc_protraction_r", 1},
    {"pectoralis_minor_rib4_r", "sc_protraction_r", 1},
    {"pectoralis_minor_rib4_r", "sc_elevation_r", -1},
    {"subclavius_r", "sc_elevation_r", -1},
    {"pectoralis_major_clavicular_whole_r", "arm_flex_r", 1},
    {"pectoralis_major_sternal_whole_r", "arm_add_r", 1},
    {"pectoralis_major_sternal_whole_r", "arm_rot_r", 1},
    {"latissimus_dorsi_lumbar_whole_r", "arm_flex_r", -1},
    {"latissimus_dorsi_lumbar_whole_r", "arm_add_r", 1},
    {"latissimus_dorsi_lumbar_whole_r", "arm_rot_r", 1},
    {"teres_major_lower_r", "arm_flex_r", -1},
    {"teres_major_lower_r", "arm_add_r", 1},
    {"teres_major_lower_r", "arm_rot_r", 1},
    {"deltoideus_anterior_whole_r", "arm_flex_r", 1},
    {"deltoideus_middle_whole_r", "arm_add_r", -1},
    {"deltoideus_posterior_whole_r", "arm_flex_r", -1},
    {"supraspinatus_inner_r", "arm_add_r", -1},
    {"infraspinatus_upper_r", "arm_rot_r", -1},
    {"teres_minor_lower_r", "arm_rot_r", -1},
    {"subscapularis_middle_r", "arm_rot_r", 1},
    {"coracobrachialis_r", "arm_flex_r", 1},
    {"coracobrachialis_r", "arm_add_r", 1},
    {"biceps_brachii_short_whole_r", "arm_flex_r", 1},
    {"biceps_brachii_long_whole_r", "elbow_flex_r", 1},
    {"biceps_brachii_short_whole_r", "elbow_flex_r", 1},
    {"biceps_brachii_short_whole_r", "pro_sup_r", -1},
    {"triceps_brachii_long_whole_r", "elbow_flex_r", -1},
    {"triceps_brachii_long_whole_r", "arm_flex_r", -1},
    {"triceps_brachii_lateral_whole_r", "elbow_flex_r", -1},
    {"triceps_brachii_medial_whole_r", "elbow_flex_r", -1},
    {"anconeus_r", "elbow_flex_r", -1},
    {"brachialis_inner_r", "elbow_flex_r", 1},
    {"brachioradialis_r", "elbow_flex_r", 1},
    {"pronator_teres_humeral_r", "pro_sup_r", 1},
    {"pronator_teres_humeral_r", "elbow_flex_r", 1},
    {"pronator_quadratus_upper_r", "pro_sup_r", 1},
    {"supinator_deep_r", "pro_sup_r", -1},
    {"extensor_carpi_radialis_longus_r", "wrist_flex_r", -1},
    {"extensor_carpi_radialis_longus_r", "wrist_dev_r", 1},
    {"extensor_carpi_radialis_brevis_r", "wrist_flex_r", -1},
    {"extensor_carpi_ulnaris_r", "wrist_flex_r", -1},
    {"extensor_carpi_ulnaris_r", "wrist_dev_r", -1},
    {"flexor_carpi_radialis_r", "wrist_flex_r", 1},
    {"flexor_carpi_radialis_r", "wrist_dev_r", 1},
    {"flexor_carpi_ulnaris_humeral_r", "wrist_flex_r", 1},
    {"flexor_carpi_ulnaris_humeral_r", "wrist_dev_r", -1},
    {"palmaris_longus_r", "wrist_flex_r", 1},
    {"flexor_digitorum_superficialis_index_r", "index_pip_r", 1},
    {"flexor_digitorum_superficialis_ring_r", "ring_mcp_flex_r", 1},
    {"flexor_digitorum_superficialis_middle_r", "wrist_flex_r", 1},
    {"flexor_digitorum_profundus_index_r", "index_mcp_flex_r", 1},
    {"flexor_digitorum_profundus_little_whole_r", "little_pip_r", 1},
    {"extensor_digitorum_middle_whole_r", "middle_mcp_flex_r", -1},
    {"extensor_digitorum_ring_whole_r", "ring_pip_r", -1},
    {"extensor_digitorum_index_whole_r", "wrist_flex_r", -1},
    {"flexor_pollicis_longus_r", "thumb_ip_r", 1},
    {"flexor_pollicis_longus_r", "thumb_mcp_r", 1},
    {"flexor_pollicis_longus_r", "cmc_flex_r", 1},
    {"extensor_pollicis_longus_r", "thumb_ip_r", -1},
    {"extensor_pollicis_longus_r", "thumb_mcp_r", -1},
    {"extensor_pollicis_brevis_r", "thumb_mcp_r", -1},
    {"abductor_pollicis_longus_metacarpal_r", "cmc_flex_r", -1},
    {"abductor_pollicis_longus_metacarpal_r", "cmc_abd_r", 1},
    {"abductor_pollicis_longus_metacarpal_r", "wrist_dev_r", 1},
};

// Muscles or slips that only the detailed body has.
constexpr Action kDetailed[] = {
    {"longissimus_thoracis_T9_r", "T11_extension", 1},
    {"iliocostalis_lumborum_L2_r", "L4_bending", 1},
    {"iliocostalis_lumborum_L2_r", "L4_extension", 1},
    {"rotatores_T6_r", "T6_rotation", 1},
    {"multifidus_thoracis_T5_r", "T6_rotation", 1},
    {"multifidus_cervicis_C4_r", "C5_extension", 1},
    {"interspinales_L3_r", "L3_extension", 1},
    {"intertransversarii_lateral_L2_r", "L2_bending", 1},
    {"levatores_costarum_rib6_r", "T5_bending", 1},
    {"iliocostalis_cervicis_C6_r", "C7_bending", 1},
    {"semispinalis_thoracis_T2_r", "T4_rotation", 1},
    {"sternocleidomastoid_clavicular_r", "C6_bending", 1},
    {"scalenus_posterior_C6_r", "T1_bending", 1},
    {"splenius_cervicis_T3_r", "C2_rotation", -1},
    {"abductor_digiti_minimi_r", "little_mcp_abd_r", -1},
    {"flexor_digiti_minimi_r", "little_mcp_flex_r", 1},
    {"extensor_indicis_r", "wrist_flex_r", -1},
    {"adductor_pollicis_transverse_r", "cmc_abd_r", -1},
    {"adductor_pollicis_transverse_r", "thumb_mcp_r", 1},
    {"abductor_pollicis_brevis_r", "cmc_abd_r", 1},
    {"opponens_pollicis_r", "cmc_flex_r", 1},
    {"opponens_pollicis_r", "cmc_abd_r", 1},
    {"flexor_pollicis_brevis_r", "thumb_mcp_r", 1},
    {"brachialis_outer_r", "elbow_flex_r", 1},
    {"supinator_superficial_r", "pro_sup_r", -1},
};

// Signs must not hang on a rounding: no arm of these is smaller [m].
constexpr double kSmallestArm = 0.0015;

std::string other_side(std::string_view name) {
  std::string other(name);
  if (other.ends_with("_r")) other.back() = 'l';
  return other;
}

// On the left a vertebra bends and turns the other way; paired joints have mirrored coordinates.
int mirrored_sign(const Action& action) {
  const bool midline = !action.coordinate.ends_with("_r");
  return midline && !action.coordinate.ends_with("_extension") ? -action.sign : action.sign;
}

// A body in poses as in walking: arms swing by 25 degrees, elbows bend up to 40, and each joint of
// the spine turns by up to 2 degrees about each axis.
class Mover {
 public:
  explicit Mover(Level level)
      : model_(whole_body({.level = level})),
        tree_(compile_tree(model_)),
        ws_(tree_),
        arms_(tree_.unknown_v.size()) {}

  const MusculoskeletalModel& model() const { return model_; }

  void pose_arms(double arm_flex, double elbow_flex) {
    for (const char* side : {"_r", "_l"}) {
      q(std::string("arm_flex") + side) = arm_flex;
      q(std::string("elbow_flex") + side) = elbow_flex;
    }
  }

  // A vertebra's coordinate is turned by turn(name).
  template <typename Turn>
  void pose_spine(const Turn& turn) {
    for (const Coordinate& c : model_.coordinates) {
      const std::string& bone = model_
                                    .bodies[static_cast<std::size_t>(
                                        model_.joints[static_cast<std::size_t>(c.joint)].child)]
                                    .name;
      const bool vertebra = bone == "skull" || (bone.size() <= 3 && bone.find_first_of("LTC") == 0);
      if (vertebra) q(c.name) = turn(c.name);
    }
  }

  double moment_arm(std::string_view wire, std::string_view coordinate) {
    update_kinematics(tree_, ws_);
    moment_arms(path(wire), tree_, ws_, arms_);
    const auto c = static_cast<std::size_t>(index(coordinate));
    return arms_[static_cast<std::size_t>(
        tree_.unknown_of_v[static_cast<std::size_t>(tree_.v_of_coordinate[c])])];
  }

  void update() { update_poses(tree_, ws_); }
  double length(const PathElement& element) const { return path_length(element, tree_, ws_); }

  // Where no solver is there to say where its virtual links go.
  bool ends_on_virtual_links(const PathElement& element) const {
    for (const PathPoint& point : element.points) {
      if (model_.bodies[static_cast<std::size_t>(point.body)].virtual_link) return true;
    }
    return false;
  }

 private:
  int index(std::string_view coordinate) const {
    const int c = model_.find_coordinate(std::string(coordinate));
    if (c < 0) throw std::logic_error("no coordinate " + std::string(coordinate));
    return c;
  }
  double& q(std::string_view coordinate) {
    return ws_.q[static_cast<std::size_t>(
        tree_.q_of_coordinate[static_cast<std::size_t>(index(coordinate))])];
  }
  const PathElement& path(std::string_view wire) const {
    for (const PathElement& element : model_.paths) {
      if (element.name == wire) return element;
    }
    throw std::logic_error("no wire " + std::string(wire));
  }

  MusculoskeletalModel model_;
  KinematicTree tree_;
  KinematicWorkspace ws_;
  std::vector<double> arms_;
};

// Calls check() in some poses of walking, the neutral one first.
template <typename Check>
void in_poses_of_walking(Mover& body, const Check& check) {
  check();
  for (const double arm : {-25.0, 0.0, 25.0}) {
    for (const double elbow : {0.0, 20.0, 40.0}) {
      body.pose_arms(arm * kDegree, elbow * kDegree);
      check();
    }
  }
  std::mt19937 random(7);
  std::uniform_real_distribution<double> turn(-2.0 * kDegree, 2.0 * kDegree);
  for (int trial = 0; trial < 20; ++trial) {
    body.pose_spine([&](std::string_view) { return turn(random); });
    check();
  }
  for (const char* motion : {"_extension", "_bending", "_rotation"}) {
    for (const double way : {-2.0, 2.0}) {
      body.pose_spine(
          [&](std::string_view name) { return name.ends_with(motion) ? way * kDegree : 0.0; });
      check();
    }
  }
}

template <std::size_t N>
void expect_actions(Level level, const Action (&actions)[N]) {
  Mover body(level);
  in_poses_of_walking(body, [&] {
    for (const Action& action : actions) {
      EXPECT_GE(action.sign * body.moment_arm(action.wire, action.coordinate), kSmallestArm)
          << action.wire << " about " << action.coordinate;
      const std::string wire = other_side(action.wire), coordinate = other_side(action.coordinate);
      EXPECT_GE(mirrored_sign(action) * body.moment_arm(wire, coordinate), kSmallestArm)
          << wire << " about " << coordinate;
    }
  });
}

TEST(WholeBodyTrunkArm, PullsAsTextbooksSayWhenSimplified) {
  expect_actions(Level::kSimplified, kSimplified);
}

TEST(WholeBodyTrunkArm, PullsAsTextbooksSayWhenDetailed) {
  expect_actions(Level::kDetailed, kDetailed);
}

// Walking asks no muscle for more than its natural length and strains no tendon or ligament by more
// than 2 %, of those of trunk and arm that end on bones alone.
TEST(WholeBodyTrunkArm, WalksWithoutStretchingItsWires) {
  for (const Level level : {Level::kSimplified, Level::kDetailed}) {
    Mover body(level);
    int wires = 0;
    in_poses_of_walking(body, [&] {
      body.update();
      wires = 0;
      for (const PathElement& path : body.model().paths) {
        if (path.source.file == "model/whole_body/wires_leg.csv") continue;
        if (body.ends_on_virtual_links(path)) continue;
        ++wires;
        const double most = path.kind == PathElement::Kind::kMuscle ? 1.0 : 1.02;
        EXPECT_LE(body.length(path), most * path.natural_length) << path.name;
      }
    });
    EXPECT_EQ(wires, level == Level::kSimplified ? 264 : 630);
  }
}

// Wires, virtual links of both sides.
TEST(WholeBodyTrunkArm, HasItsWiresAndVirtualLinks) {
  const auto count = [](const auto& elements, std::string_view file) {
    int n = 0;
    for (const auto& element : elements) n += element.source.file.ends_with(file) ? 1 : 0;
    return n;
  };
  const MusculoskeletalModel simplified = whole_body({.level = Level::kSimplified});
  const MusculoskeletalModel detailed = whole_body({.level = Level::kDetailed});
  EXPECT_EQ(count(simplified.paths, "wires_trunk.csv"), 2 * 72);
  EXPECT_EQ(count(simplified.paths, "wires_arm.csv"), 2 * 60);
  EXPECT_EQ(count(detailed.paths, "wires_trunk.csv"), 2 * 320);
  EXPECT_EQ(count(detailed.paths, "wires_arm.csv"), 2 * 163);
  EXPECT_EQ(count(detailed.bodies, "virtual_links_trunk.csv"), 2 * 12);
  EXPECT_EQ(count(detailed.bodies, "virtual_links_arm.csv"), 2 * 10);
}

}  // namespace
}  // namespace sinew
