#pragma once

#include <Eigen/Core>
#include <array>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "data/input_error.h"
#include "data/numbers.h"
#include "model/scalar_function.h"
#include "model/spatial.h"

/// The model as plain values: what a model file says, in SI and radians. Bodies, joints,
/// coordinates and so on refer to each other by index. Index 0 of `bodies` is ground, and every
/// body stands after its parent, so that one loop over the bodies goes from the root outward.
namespace sinew {

struct Body {
  std::string name;
  double mass = 0.0;                                // [kg]
  Eigen::Vector3d p_BCm = Eigen::Vector3d::Zero();  // mass centre [m]
  Eigen::Matrix3d I_BCm = Eigen::Matrix3d::Zero();  // about the mass centre, in B [kg m²]
  // A furcation of muscles or tendons (Ayusawa & Nakamura 2012, sec. IV): massless, six degrees of
  // freedom, held by the paths that end on it.
  bool virtual_link = false;
  SourceLocation source;
};

/// One degree of freedom as users see it.
struct Coordinate {
  enum class Motion { kRotational, kTranslational, kCoupled };

  std::string name;
  int joint = -1;
  Motion motion = Motion::kRotational;  // kRotational values are angles [rad], kTranslational [m]
  double default_value = 0.0;
  double default_speed = 0.0;
  double range_min = -std::numeric_limits<double>::infinity();
  double range_max = std::numeric_limits<double>::infinity();
  bool clamped = false;                      // the range is a bound
  bool locked = false;                       // stays at default_value
  std::optional<ScalarFunction> prescribed;  // of time [s]; set only where the file says it applies
  SourceLocation source;
};

/// One of the six steps of a custom joint: turn about, or shift along, `axis` by function(q).
struct TransformAxis {
  Eigen::Vector3d axis = Eigen::Vector3d::UnitX();
  int coordinate = -1;  // index into MusculoskeletalModel::coordinates; −1: the function of zero
  ScalarFunction function;
};

/// Connects frame F on the parent to frame M on the child.
struct Joint {
  // How M moves in F. Rotations are body-fixed X-Y-Z, translations are along F's axes and
  // coordinates come in that order, as in OpenSim and Simbody.
  enum class Kind {
    kWeld,       // no motion
    kPin,        // turns about Z
    kSlider,     // shifts along X
    kUniversal,  // turns about X, then Y
    kBall,       // turns about X, Y, Z; its speeds are the angular velocity of M in F
    kGimbal,     // turns about X, Y, Z
    kPlanar,     // turns about Z, shifts along X, Y
    kFree,       // turns about X, Y, Z, shifts along X, Y, Z; speeds as kBall
    kEllipsoid,  // turns about X, Y, Z; M's origin keeps to an ellipsoid, M's z axis outward
    kCustom,     // `axes`: three turns in turn, then shifts along three axes of F
  };

  std::string name;
  Kind kind = Kind::kWeld;
  int parent = 0;  // body index
  int child = 0;   // body index
  RigidTransform X_PF;
  RigidTransform X_BM;
  std::vector<int> coordinates;       // indices, in the order of the joint's definition
  std::array<TransformAxis, 6> axes;  // kCustom: rotation1..3, translation1..3
  Eigen::Vector3d radii = Eigen::Vector3d::Zero();  // kEllipsoid [m]
  SourceLocation source;
};

/// dependent = function(independent); eliminated when the model is compiled.
struct CoordinateCoupler {
  std::string name;
  int dependent = -1;
  int independent = -1;
  ScalarFunction function;
  SourceLocation source;
};

/// Frame F1 on body1 coincides with frame F2 on body2.
struct WeldConstraint {
  std::string name;
  int body1 = 0, body2 = 0;
  RigidTransform X_B1F1, X_B2F2;
  SourceLocation source;
};

/// A point of body1 coincides with a point of body2.
struct PointConstraint {
  std::string name;
  int body1 = 0, body2 = 0;
  Eigen::Vector3d p_B1P1 = Eigen::Vector3d::Zero(), p_B2P2 = Eigen::Vector3d::Zero();
  SourceLocation source;
};

struct Marker {
  std::string name;
  int body = 0;
  Eigen::Vector3d p_BM = Eigen::Vector3d::Zero();  // [m]
  bool fixed = false;                              // not to be moved when markers are placed
  SourceLocation source;
};

/// A point on the path of a muscle or ligament.
struct PathPoint {
  enum class Kind { kFixed, kConditional, kMoving };

  std::string name;
  Kind kind = Kind::kFixed;
  int body = 0;
  Eigen::Vector3d p_BP = Eigen::Vector3d::Zero();     // kFixed, kConditional [m]
  int condition_coordinate = -1;                      // kConditional: on the path while the
  double condition_min = kNaN, condition_max = kNaN;  // coordinate is within these
  std::array<TransformAxis, 3> location;  // kMoving: x, y, z of the point; `axis` unused
};

/// A muscle, tendon or ligament along a path; the wires of the IK come from these.
struct PathElement {
  enum class Kind {
    kMuscle,
    kTendon,  // between virtual links and bones; OpenSim's PathSpring
    kLigament,
    kActuator,
  };

  std::string name;
  Kind kind = Kind::kMuscle;
  std::string class_name;  // as the file has it, e.g. Thelen2003Muscle
  std::vector<PathPoint> points;
  std::vector<std::string> wrap_objects;  // the surfaces the path runs over; not treated yet
  double max_isometric_force = kNaN;      // muscles [N]
  double optimal_fiber_length = kNaN;     // muscles [m]
  double tendon_slack_length = kNaN;      // muscles [m]
  double pennation_angle = kNaN;          // muscles, at optimal fiber length [rad]
  // What the path does not exceed, eq. (38)'s l^d [m]. Tendons and ligaments: the length at which
  // they become taut. Muscles: tendon_slack_length + 1.5 optimal_fiber_length, where the fibres can
  // no longer pull (Zajac 1989, Crit Rev Biomed Eng 17:359-411). NaN: no wire.
  double natural_length = kNaN;
  double stiffness = kNaN;    // tendons [N/m]
  double dissipation = kNaN;  // tendons [s/m]
  double pcsa_force = kNaN;   // ligaments: the force that scales their curve [N]
  SourceLocation source;
};

/// An element of the model that Sinew knows of and does not treat.
struct UnsupportedElement {
  enum class Effect { kNone, kKinematics, kDynamics };  // what it would change

  std::string class_name;
  std::string name;
  Effect effect = Effect::kNone;
  SourceLocation source;
};

struct MusculoskeletalModel {
  std::string name;
  int document_version = 0;                     // as OpenSim writes it, e.g. 40000
  Eigen::Vector3d gravity{0.0, -9.80665, 0.0};  // [m/s²]
  std::vector<Body> bodies;                     // bodies[0] is ground
  std::vector<Joint> joints;                    // joints[b − 1] carries bodies[b]
  std::vector<Coordinate> coordinates;          // by joint, each joint's own in order
  std::vector<CoordinateCoupler> couplers;
  std::vector<WeldConstraint> welds;
  std::vector<PointConstraint> point_constraints;
  std::vector<Marker> markers;
  std::vector<PathElement> paths;
  std::vector<UnsupportedElement> unsupported;
  std::vector<Warning> warnings;  // of reading it

  double total_mass() const;
  int virtual_link_count() const;
  // Indices by name, or −1. Exact match.
  int find_body(const std::string& body_name) const;
  int find_joint(const std::string& joint_name) const;
  int find_coordinate(const std::string& coordinate_name) const;
  int find_marker(const std::string& marker_name) const;
};

/// The length that a muscle's path does not exceed, see PathElement::natural_length [m]. NaN where
/// the lengths of its parts are not known.
double muscle_natural_length(const PathElement& muscle);

/// Checks every invariant stated above: indices in range, parents before children, names unique,
/// couplers without cycles, numbers finite, masses and inertias physical. Throws InputError naming
/// the element. Readers and authors of models call it last; compilers rely on it.
void validate(const MusculoskeletalModel& model);

}  // namespace sinew
