#include "data/reference_walk.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string_view>

namespace sinew {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

// The man.
constexpr double kMass = 75.0;                // [kg]
constexpr double kStature = 1.80;             // [m]
constexpr double kScale = kStature / 1.741;   // against de Leva's mean man
constexpr double kAnkleHeight = 0.0702;       // 0.039 of the stature, Drillis & Contini 1966 [m]
constexpr double kHeel = -0.060;              // heel behind the ankle, assumed [m]
constexpr double kHipHalfWidth = 0.0864;      // 36 % of 0.24 m; see markers.inc [m]
constexpr double kShoulderHalfWidth = 0.190;  // half of 0.259 of the stature, the breadth of both
                                              // acromia (Drillis & Contini), less 0.043 [m]
constexpr double kPatellaMass = 0.001;        // of the body's, assumed
constexpr double kToesMass = 0.14;            // of the foot's; 0.217 of 1.567 kg in Delp 1990
const Vector3d kToesSize(0.07, 0.02, 0.09);   // [m], assumed

struct Segment {
  std::string_view name;
  double mass, length, centre, r_sagittal, r_transverse, r_longitudinal;
};

constexpr Segment kSegments[] = {
#include "data/reference_walk/segments.inc"
};

struct MarkerPlace {
  const char* name;
  const char* body;
  std::array<double, 3> p_BM;
};

constexpr MarkerPlace kMarkers[] = {
#include "data/reference_walk/markers.inc"
};

const Segment& segment(std::string_view name) {
  for (const Segment& s : kSegments) {
    if (s.name == name) return s;
  }
  throw std::logic_error("no segment of that name");
}

double length(std::string_view name) { return kScale * segment(name).length; }

struct MassProperties {
  double mass = 0.0;                  // [kg]
  Vector3d p_BCm = Vector3d::Zero();  // [m]
  Matrix3d I_BCm = Matrix3d::Zero();  // about the mass centre [kg m²]
};

// A segment from `origin` on along the unit vector `along`.
MassProperties segment_properties(std::string_view name, const Vector3d& origin,
                                  const Vector3d& along) {
  const Segment& s = segment(name);
  const double l = length(name);
  const bool upright = along.y() != 0.0;
  const Vector3d radii = upright ? Vector3d(s.r_sagittal, s.r_longitudinal, s.r_transverse)
                                 : Vector3d(s.r_longitudinal, s.r_sagittal, s.r_transverse);
  return {kMass * s.mass, origin + s.centre * l * along,
          Matrix3d((kMass * s.mass * l * l * radii.array().square()).matrix().asDiagonal())};
}

MassProperties box(double mass, const Vector3d& centre, const Vector3d& size) {
  const Vector3d squares = size.array().square();
  return {mass, centre,
          Matrix3d((mass / 12.0 * (Vector3d::Constant(squares.sum()) - squares)).asDiagonal())};
}

Matrix3d point_inertia(double mass, const Vector3d& p) {
  return mass * (p.squaredNorm() * Matrix3d::Identity() - p * p.transpose());
}

// Steiner; sign −1 takes `b` out of `a`.
MassProperties combine(const MassProperties& a, const MassProperties& b, double sign = 1.0) {
  MassProperties c;
  c.mass = a.mass + sign * b.mass;
  c.p_BCm = (a.mass * a.p_BCm + sign * b.mass * b.p_BCm) / c.mass;
  c.I_BCm = a.I_BCm + point_inertia(a.mass, a.p_BCm - c.p_BCm) +
            sign * (b.I_BCm + point_inertia(b.mass, b.p_BCm - c.p_BCm));
  return c;
}

// The mtp joint, on a line through the metatarsals' heads: Delp 1990 has it 0.179 m before the heel
// of a foot of 0.25 m.
const Vector3d kToesOrigin(kHeel + 0.190, -0.050, 0.0);

MassProperties toes_in_calcn() {
  return box(kToesMass * segment("foot").mass * kMass,
             kToesOrigin + Vector3d(0.5 * kToesSize.x(), -0.010, 0.0), kToesSize);
}

MassProperties calcn_properties() {
  const Vector3d heel(kHeel, -0.55 * kAnkleHeight, 0.0);  // mid-height of the foot
  return combine(segment_properties("foot", heel, Vector3d::UnitX()), toes_in_calcn(), -1.0);
}

MassProperties torso_properties() {
  const Vector3d down = -Vector3d::UnitY();
  const double xiphion = length("middle_trunk"), sternum = xiphion + length("upper_trunk");
  // Neck: what is left of the stature above the ankles' height and between the segments.
  const double vertex =
      kStature - kAnkleHeight - length("shank") - length("thigh") - length("lower_trunk");
  return combine(combine(segment_properties("middle_trunk", {0, xiphion, 0}, down),
                         segment_properties("upper_trunk", {0, sternum, 0}, down)),
                 segment_properties("head", {0, vertex, 0}, down));
}

MassProperties ulna_properties() {
  const Vector3d down = -Vector3d::UnitY();
  return combine(segment_properties("forearm", Vector3d::Zero(), down),
                 segment_properties("hand", {0, -length("forearm"), 0}, down));
}

MassProperties femur_properties() {
  MassProperties femur = segment_properties("thigh", Vector3d::Zero(), -Vector3d::UnitY());
  const double part = 1.0 - kPatellaMass / segment("thigh").mass;  // the patella is a part of it
  femur.mass *= part;
  femur.I_BCm *= part;
  return femur;
}

// Writes the document. Everything is described for the right side; on the left z changes its sign,
// and so do turns about X and Y.
class ModelWriter {
 public:
  std::string write();

 private:
  struct Coordinate {
    std::string name;
    double value, low, high;  // [rad or m]
    bool clamped = true, locked = false;
  };
  struct Axis {
    int coordinate;  // −1: none
    Vector3d axis;
  };

  void begin_side(bool left) {
    z_ = left ? -1.0 : 1.0;
    suffix_ = left ? "_l" : "_r";
  }
  void body(const std::string& name, const MassProperties& properties);
  void joint(const std::string& name, const std::string& parent, const std::string& child,
             const Vector3d& p_PF, const std::vector<Coordinate>& coordinates,
             const std::vector<Axis>& turns, bool translates = false);
  void axis(const char* name, const Vector3d& axis, const std::string& coordinate);
  void root();
  void leg();
  void arm();
  void coupler();
  void marker(const MarkerPlace& place, bool left);

  std::string bodies_, joints_, constraints_, markers_;
  double z_ = 1.0;
  std::string suffix_;
};

std::string text_of(const Vector3d& v) {
  // Adding zero turns −0 into 0.
  return fmt::format("{} {} {}", v.x() + 0.0, v.y() + 0.0, v.z() + 0.0);
}

void ModelWriter::body(const std::string& name, const MassProperties& properties) {
  const Matrix3d& I = properties.I_BCm;
  const Vector3d& c = properties.p_BCm;
  bodies_ += fmt::format(
      "      <Body name=\"{}\">\n"
      "        <mass>{}</mass>\n"
      "        <mass_center>{}</mass_center>\n"
      "        <inertia>{} {} {} {} {} {}</inertia>\n"
      "      </Body>\n",
      name, properties.mass, text_of({c.x(), c.y(), z_ * c.z()}), I(0, 0), I(1, 1), I(2, 2),
      I(0, 1) + 0.0, z_ * I(0, 2) + 0.0, z_ * I(1, 2) + 0.0);
}

void ModelWriter::axis(const char* name, const Vector3d& axis, const std::string& coordinate) {
  joints_ += fmt::format(
      "          <TransformAxis name=\"{}\">\n"
      "            <coordinates>{}</coordinates>\n"
      "            <axis>{}</axis>\n"
      "            {}\n"
      "          </TransformAxis>\n",
      name, coordinate, text_of(axis),
      coordinate.empty()
          ? "<Constant name=\"function\"><value>0</value></Constant>"
          : "<LinearFunction name=\"function\"><coefficients>1 0</coefficients></LinearFunction>");
}

void ModelWriter::joint(const std::string& name, const std::string& parent,
                        const std::string& child, const Vector3d& p_PF,
                        const std::vector<Coordinate>& coordinates, const std::vector<Axis>& turns,
                        bool translates) {
  const auto coordinate_name = [&](int c) {
    return c < 0 ? std::string() : coordinates[static_cast<std::size_t>(c)].name;
  };
  joints_ += fmt::format(
      "      <CustomJoint name=\"{}\">\n"
      "        <socket_parent_frame>{}_offset</socket_parent_frame>\n"
      "        <socket_child_frame>{}_offset</socket_child_frame>\n"
      "        <coordinates>\n",
      name, parent, child);
  for (const Coordinate& c : coordinates) {
    joints_ += fmt::format(
        "          <Coordinate name=\"{}\">\n"
        "            <default_value>{}</default_value>\n"
        "            <range>{} {}</range>\n"
        "            <clamped>{}</clamped>\n"
        "            <locked>{}</locked>\n"
        "          </Coordinate>\n",
        c.name, c.value, c.low, c.high, c.clamped, c.locked);
  }
  joints_ += "        </coordinates>\n        <frames>\n";
  const std::string parent_path = parent == "ground" ? "/ground" : "/bodyset/" + parent;
  const std::array<std::array<std::string, 3>, 2> frames = {
      {{parent, parent_path, text_of({p_PF.x(), p_PF.y(), z_ * p_PF.z()})},
       {child, "/bodyset/" + child, "0 0 0"}}};
  for (const auto& [frame, path, translation] : frames) {
    joints_ += fmt::format(
        "          <PhysicalOffsetFrame name=\"{}_offset\">\n"
        "            <socket_parent>{}</socket_parent>\n"
        "            <translation>{}</translation>\n"
        "            <orientation>0 0 0</orientation>\n"
        "          </PhysicalOffsetFrame>\n",
        frame, path, translation);
  }
  joints_ += "        </frames>\n        <SpatialTransform>\n";
  static constexpr const char* kNames[] = {"rotation1",    "rotation2",    "rotation3",
                                           "translation1", "translation2", "translation3"};
  for (std::size_t i = 0; i < 3; ++i) {
    const Axis& turn = turns[i];
    axis(kNames[i], {z_ * turn.axis.x(), z_ * turn.axis.y(), turn.axis.z()},
         coordinate_name(turn.coordinate));
  }
  for (int i = 0; i < 3; ++i) {
    axis(kNames[3 + i], Vector3d::Unit(i), coordinate_name(translates ? 3 + i : -1));
  }
  joints_ += "        </SpatialTransform>\n      </CustomJoint>\n";
}

const Vector3d kX = Vector3d::UnitX(), kY = Vector3d::UnitY(), kZ = Vector3d::UnitZ();

void ModelWriter::root() {
  begin_side(false);
  const double hip_height = kAnkleHeight + length("shank") + length("thigh");
  const double navel = length("lower_trunk");
  body("pelvis", segment_properties("lower_trunk", {0, navel, 0}, -kY));
  body("torso", torso_properties());
  // Ranges of the pelvis say what is usual; they bind nothing.
  joint("ground_pelvis", "ground", "pelvis", Vector3d::Zero(),
        {{"pelvis_tilt", 0, -1.6, 1.6, false},
         {"pelvis_list", 0, -1.6, 1.6, false},
         {"pelvis_rotation", 0, -3.2, 3.2, false},
         {"pelvis_tx", 0, -10, 10, false},
         {"pelvis_ty", hip_height, -1, 3, false},
         {"pelvis_tz", 0, -10, 10, false}},
        {{0, kZ}, {1, kX}, {2, kY}}, true);
  joint("back", "pelvis", "torso", {0, navel, 0},
        {{"lumbar_extension", 0, -1.0, 0.6},
         {"lumbar_bending", 0, -0.7, 0.7},
         {"lumbar_rotation", 0, -0.8, 0.8}},
        {{0, kZ}, {1, kX}, {2, kY}});
}

// Axis of the subtalar joint, 42° up and 23° inward from straight ahead: Inman VT (1976) The Joints
// of the Ankle, Williams & Wilkins.
const Vector3d kSubtalarAxis(0.684, 0.669, -0.290);
// The patella turns about the knee by 0.65 of the knee's flexion: its flexion in the groove of the
// femur lags behind by a third, Amis AA et al. (2006) J Orthop Res 24:2201-2211.
constexpr double kPatellaRatio = 0.65;

void ModelWriter::leg() {
  const double knee = -length("thigh"), ankle = -length("shank");
  const auto named = [&](const char* name) { return name + suffix_; };
  const Vector3d down = -kY;
  body(named("femur"), femur_properties());
  body(named("tibia"), segment_properties("shank", Vector3d::Zero(), down));
  body(named("patella"), box(kPatellaMass * kMass, {0.048, 0.010, 0}, {0.02, 0.045, 0.045}));
  body(named("calcn"), calcn_properties());
  MassProperties toes = toes_in_calcn();
  toes.p_BCm -= kToesOrigin;
  body(named("toes"), toes);

  joint(named("hip"), "pelvis", named("femur"), {0, 0, kHipHalfWidth},
        {{named("hip_flexion"), 0, -0.8, 2.2},
         {named("hip_adduction"), 0, -0.9, 0.6},
         {named("hip_rotation"), 0, -0.8, 0.8}},
        {{0, kZ}, {1, kX}, {2, kY}});
  joint(named("knee"), named("femur"), named("tibia"), {0, knee, 0},
        {{named("knee_angle"), 0, -0.2, 2.4}}, {{0, -kZ}, {-1, kX}, {-1, kY}});
  joint(named("patellofemoral"), named("femur"), named("patella"), {0, knee, 0},
        {{named("knee_angle") + "_beta", 0, -0.2, 2.4, false}}, {{0, -kZ}, {-1, kX}, {-1, kY}});
  joint(named("foot"), named("tibia"), named("calcn"), {0, ankle, 0},
        {{named("ankle_angle"), 0, -1.0, 0.7}, {named("subtalar_angle"), 0, -0.5, 0.5}},
        {{0, kZ}, {1, kSubtalarAxis}, {-1, kX}});
  joint(named("mtp"), named("calcn"), named("toes"), kToesOrigin,
        {{named("mtp_angle"), 0, -0.5, 1.0, true, true}}, {{0, kZ}, {-1, kX}, {-1, kY}});
  coupler();
}

void ModelWriter::arm() {
  const auto named = [&](const char* name) { return name + suffix_; };
  body(named("humerus"), segment_properties("upper_arm", Vector3d::Zero(), -kY));
  body(named("ulna"), ulna_properties());
  // Shoulders 0.5155 m above the hips in a man of 1.741 m: de Leva 1996, from mid-shoulder to
  // mid-hip.
  joint(named("shoulder"), "torso", named("humerus"),
        {0, 0.5155 * kScale - length("lower_trunk"), kShoulderHalfWidth},
        {{named("arm_flex"), 0, -1.2, 2.6}, {named("arm_add"), 0, -2.1, 0.6}},
        {{0, kZ}, {1, kX}, {-1, kY}});
  joint(named("elbow"), named("humerus"), named("ulna"), {0, -length("upper_arm"), 0},
        {{named("elbow_flex"), 0, -0.1, 2.6}}, {{0, kZ}, {-1, kX}, {-1, kY}});
}

void ModelWriter::coupler() {
  constraints_ += fmt::format(
      "      <CoordinateCouplerConstraint name=\"patella{0}_follows_knee\">\n"
      "        <isEnforced>true</isEnforced>\n"
      "        <coupled_coordinates_function>\n"
      "          <LinearFunction><coefficients>{1} 0</coefficients></LinearFunction>\n"
      "        </coupled_coordinates_function>\n"
      "        <independent_coordinate_names>knee_angle{0}</independent_coordinate_names>\n"
      "        <dependent_coordinate_name>knee_angle{0}_beta</dependent_coordinate_name>\n"
      "      </CoordinateCouplerConstraint>\n",
      suffix_, kPatellaRatio);
}

void ModelWriter::marker(const MarkerPlace& place, bool left) {
  std::string name = place.name, body = place.body;
  if (left) {
    name.front() = 'L';
    body.back() = 'l';
  }
  const auto& [x, y, z] = place.p_BM;
  markers_ += fmt::format(
      "      <Marker name=\"{}\">\n"
      "        <socket_parent_frame>/bodyset/{}</socket_parent_frame>\n"
      "        <location>{}</location>\n"
      "        <fixed>false</fixed>\n"
      "      </Marker>\n",
      name, body, text_of({x, y, left ? -z : z}));
}

std::string ModelWriter::write() {
  root();
  for (const bool left : {false, true}) {
    begin_side(left);
    leg();
    arm();
    for (const MarkerPlace& place : kMarkers) {
      const bool paired = std::string_view(place.body).ends_with("_r");
      if (paired || !left) marker(place, left);
    }
  }
  const auto set = [](const char* name, const std::string& objects) {
    return fmt::format("    <{0}>\n      <objects>\n{1}      </objects>\n    </{0}>\n", name,
                       objects);
  };
  return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
         "<OpenSimDocument Version=\"40000\">\n"
         "  <Model name=\"reference_walk\">\n"
         "    <length_units>meters</length_units>\n"
         "    <force_units>N</force_units>\n"
         "    <gravity>0 -9.80665 0</gravity>\n" +
         set("BodySet", bodies_) + set("JointSet", joints_) + set("ConstraintSet", constraints_) +
         set("MarkerSet", markers_) + "  </Model>\n</OpenSimDocument>\n";
}

// Which harmonics of the stride a row of curves.inc has. What both sides share repeats with each
// step (even) or changes its side with it (odd).
enum class Harmonics { kAll, kEven, kOdd };

struct CurveRow {
  const char* coordinate;
  Harmonics harmonics;
  std::vector<double> coefficients;  // mean, a, b, a, b, …
};

const std::vector<CurveRow>& curve_rows() {
  using enum Harmonics;
  static const std::vector<CurveRow> rows = {
#include "data/reference_walk/curves.inc"
  };
  return rows;
}

FourierSeries series_of(const CurveRow& row) {
  FourierSeries series;
  series.mean = row.coefficients[0];
  const std::size_t stride = row.harmonics == Harmonics::kAll ? 1 : 2;
  std::size_t k = row.harmonics == Harmonics::kEven ? 2 : 1;
  for (std::size_t i = 1; i + 1 < row.coefficients.size(); i += 2, k += stride) {
    series.cosines.resize(k, 0.0);
    series.sines.resize(k, 0.0);
    series.cosines[k - 1] = row.coefficients[i];
    series.sines[k - 1] = row.coefficients[i + 1];
  }
  return series;
}

// Stride of 1.10 s and 1.50 m; Winter 2009 has 1.14 s and 1.51 m for the natural cadence.
constexpr double kStrideTime = 1.10;
constexpr double kStrideLength = 1.50;
// Perry & Burnfield 2010: the foot is on the floor for 62 % of the stride.
constexpr double kStance = 0.62;
// Murray MP, Drought AB, Kory RC (1964) J Bone Joint Surg Am 46:335-360: 8 cm between the heels'
// lines and 7 degrees of toeing out.
constexpr double kStepWidth = 0.08;
constexpr double kToeOut = 7.0 * std::numbers::pi / 180.0;

WalkFoot foot(bool left) {
  const double z = left ? -1.0 : 1.0, floor = -kAnkleHeight;
  WalkFoot foot;
  foot.side = left ? "l" : "r";
  foot.body = "calcn_" + foot.side;
  foot.strike = left ? 0.5 : 0.0;
  foot.stance = kStance;
  foot.toe_out = kToeOut;
  // The heel steps on x = 0 in stride 0.
  foot.p_WB = {-kHeel * std::cos(kToeOut) + foot.strike * kStrideLength, kAnkleHeight,
               z * (0.5 * kStepWidth - kHeel * std::sin(kToeOut))};
  // Length 0.267 m (de Leva), breadth 0.055 of the stature (Drillis & Contini 1966).
  foot.outline = {{-0.060, floor, -0.022 * z}, {-0.060, floor, 0.022 * z},
                  {-0.030, floor, 0.034 * z},  {0.105, floor, 0.050 * z},
                  {0.165, floor, 0.048 * z},   {0.195, floor, 0.030 * z},
                  {0.207, floor, 0.000 * z},   {0.207, floor, -0.030 * z},
                  {0.135, floor, -0.049 * z},  {-0.030, floor, -0.032 * z}};
  // Nearly steady from the heel to the big toe, as in Winter 2009, ch. 5.
  foot.first_pressure = {-0.040, floor, 0.004 * z};
  foot.last_pressure = {0.180, floor, -0.010 * z};
  return foot;
}

}  // namespace

std::array<double, 3> evaluate(const FourierSeries& series, double phase) {
  std::array<double, 3> result{series.mean, 0.0, 0.0};
  for (std::size_t i = 0; i < series.cosines.size(); ++i) {
    const double w = 2.0 * std::numbers::pi * static_cast<double>(i + 1);
    const double c = std::cos(w * phase), s = std::sin(w * phase);
    const double a = series.cosines[i], b = series.sines[i];
    result[0] += a * c + b * s;
    result[1] += w * (b * c - a * s);
    result[2] -= w * w * (a * c + b * s);
  }
  return result;
}

std::string reference_walk_model() { return ModelWriter().write(); }

std::vector<NormativeCurve> normative_curves() {
  return {
#include "data/reference_walk/normative.inc"
  };
}

ReferenceWalk reference_walk() {
  ReferenceWalk walk;
  walk.model = reference_walk_model();
  walk.stride_time = kStrideTime;
  walk.stride_length = kStrideLength;
  for (const CurveRow& row : curve_rows()) {
    WalkCurve curve{row.coordinate, series_of(row), 0.0, 0.0};
    if (curve.coordinate == "pelvis_tx") curve.advance = kStrideLength;
    walk.curves.push_back(curve);
    if (!curve.coordinate.ends_with("_r")) continue;
    curve.coordinate.back() = 'l';
    curve.delay = 0.5;
    walk.curves.push_back(curve);
  }
  walk.feet = {foot(false), foot(true)};
  return walk;
}

}  // namespace sinew
