#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "data/input_error.h"
#include "model/osim_file.h"

namespace sinew {
namespace {

// Documents are put together from one-line parts, so that every error's line can be told: bodies
// stand from line 4, joints from line 8, the rest from line 12.
struct Parts {
  std::string version = "Version=\"40000\"";
  std::string units;
  std::vector<std::string> bodies = {body("a"), body("b"), ""};
  std::vector<std::string> joints = {pin("j1", "ground", "a", "q1"), pin("j2", "a", "b", "q2"), ""};
  std::string rest;

  static std::string body(const std::string& name, const std::string& properties = "") {
    return "<Body name=\"" + name + "\">" +
           (properties.empty() ? "<mass>1</mass><inertia>1 1 1 0 0 0</inertia>" : properties) +
           "</Body>";
  }
  static std::string sockets(const std::string& parent, const std::string& child) {
    return "<socket_parent_frame>" + parent + "</socket_parent_frame><socket_child_frame>" + child +
           "</socket_child_frame>";
  }
  static std::string coordinate(const std::string& name, const std::string& properties = "") {
    return "<coordinates><Coordinate name=\"" + name + "\">" + properties +
           "</Coordinate></coordinates>";
  }
  static std::string pin(const std::string& name, const std::string& parent,
                         const std::string& child, const std::string& coordinate_name) {
    return "<PinJoint name=\"" + name + "\">" + sockets(parent, child) +
           coordinate(coordinate_name) + "</PinJoint>";
  }
};

std::string document(const Parts& p) {
  std::string text = "<OpenSimDocument " + p.version + ">\n<Model name=\"m\">" + p.units +
                     "\n<BodySet><objects>\n";
  for (const std::string& body : p.bodies) text += body + "\n";
  text += "</objects></BodySet><JointSet><objects>\n";
  for (const std::string& joint : p.joints) text += joint + "\n";
  return text + "</objects></JointSet>\n" + p.rest + "\n</Model>\n</OpenSimDocument>\n";
}

std::string with_body(const std::string& body) {
  Parts parts;
  parts.bodies[2] = body;
  return document(parts);
}

std::string with_joint(const std::string& joint) {  // of body b, on line 9
  Parts parts;
  parts.joints[1] = joint;
  return document(parts);
}

std::string with_rest(const std::string& rest) {
  Parts parts;
  parts.rest = rest;
  return document(parts);
}

// A custom joint of body b whose first rotation is `axis`.
std::string with_axis(const std::string& axis) {
  return with_joint("<CustomJoint name=\"j2\">" + Parts::sockets("a", "b") +
                    Parts::coordinate("q2") +
                    "<SpatialTransform><TransformAxis name=\"rotation1\">" + axis +
                    "</TransformAxis></SpatialTransform></CustomJoint>");
}

std::string with_function(const std::string& function) {
  return with_axis("<coordinates>q2</coordinates><axis>1 0 0</axis><function>" + function +
                   "</function>");
}

std::string coupler(const std::string& name, const std::string& from, const std::string& to) {
  return "<CoordinateCouplerConstraint name=\"" + name + "\"><independent_coordinate_names>" +
         from + "</independent_coordinate_names><dependent_coordinate_name>" + to +
         "</dependent_coordinate_name><coupled_coordinates_function><LinearFunction/>"
         "</coupled_coordinates_function></CoordinateCouplerConstraint>";
}

std::string with_constraints(const std::string& constraints) {
  return with_rest("<ConstraintSet><objects>" + constraints + "</objects></ConstraintSet>");
}

std::string with_markers(const std::string& markers) {
  return with_rest("<MarkerSet><objects>" + markers + "</objects></MarkerSet>");
}

std::string marker(const std::string& name, const std::string& frame,
                   const std::string& location = "0 0 0") {
  return "<Marker name=\"" + name + "\"><socket_parent_frame>" + frame +
         "</socket_parent_frame><location>" + location + "</location></Marker>";
}

std::string with_path(const std::string& points) {
  return with_rest(
      "<ForceSet><objects><Thelen2003Muscle name=\"biceps\"><GeometryPath>"
      "<PathPointSet><objects>" +
      points +
      "</objects></PathPointSet></GeometryPath></Thelen2003Muscle></objects>"
      "</ForceSet>");
}

std::string point(const std::string& name, const std::string& frame) {
  return "<PathPoint name=\"" + name + "\"><socket_parent_frame>" + frame +
         "</socket_parent_frame><location>0 0 0</location></PathPoint>";
}

std::string nested(int levels) {
  std::string text = "<OpenSimDocument Version=\"40000\">";
  for (int i = 0; i < levels; ++i) text += "<a>";
  for (int i = 0; i < levels; ++i) text += "</a>";
  return text + "</OpenSimDocument>";
}

// Version 2 keeps a joint within its body.
std::string old_document(const std::string& joint) {
  return "<OpenSimDocument Version=\"20000\">\n<Model name=\"m\"><BodySet><objects>\n"
         "<Body name=\"ground\"/>\n<Body name=\"a\"><mass>1</mass><inertia_xx>1</inertia_xx>"
         "<inertia_yy>1</inertia_yy><inertia_zz>1</inertia_zz>\n<Joint>" +
         joint + "</Joint></Body>\n</objects></BodySet></Model></OpenSimDocument>";
}

std::string error_of(const std::string& content) {
  try {
    parse_osim("m.osim", content);
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

struct Case {
  const char* what;
  std::string content;
  std::string error;
};

std::vector<Case> file_cases() {
  Parts no_version, old_version, millimetres;
  no_version.version = "";
  old_version.version = "Version=\"1\"";
  millimetres.units = "<length_units>mm</length_units>";
  return {
      {"empty", "", "m.osim: is empty; expected an XML document. Was it written completely?"},
      {"only white space", std::string(std::size_t{100} << 20, ' '),
       "m.osim: is empty; expected an XML document. Was it written completely?"},
      {"binary", std::string("\x7f\x45\x4c\x46\x02\x01\x00\x00\x00\xff\xfe", 11),
       "m.osim:1: is not well-formed XML (No document element found). Is the file complete, and is "
       "it an XML file?"},
      {"text", "time\tx\n0\t1\n",
       "m.osim:3: is not well-formed XML (No document element found). Is the file complete, and is "
       "it an XML file?"},
      {"cut off", document({}).substr(0, 600),
       "m.osim:9: is not well-formed XML (Start-end tags mismatch). Is the file complete, and is "
       "it an XML file?"},
      {"cut off within a name", document({}).substr(0, 90),
       "m.osim:4: is not well-formed XML (Error parsing start element tag). Is the file complete, "
       "and is it an XML file?"},
      {"another format", "<html><body/></html>",
       "m.osim:1: is not an OpenSim document; expected <OpenSimDocument> as root, found <html>. "
       "Name an .osim model."},
      {"a setup file",
       "<OpenSimDocument Version=\"40000\">\n<InverseKinematicsTool/></OpenSimDocument>",
       "m.osim:1: holds no model; expected a <Model> element, found <InverseKinematicsTool>. Is it "
       "a setup file? Name an .osim model."},
      {"no version", document(no_version),
       "m.osim:1: has no usable document version; expected Version=\"10901\" or later. Open the "
       "model in OpenSim and save it again."},
      {"a version before files had numbers", document(old_version),
       "m.osim:1: has no usable document version; expected Version=\"10901\" or later, found 1. "
       "Open the model in OpenSim and save it again."},
      {"not SI", document(millimetres),
       "m.osim:2: <length_units> is not supported; expected meters, found mm. Scale the model to "
       "SI units."},
      {"elements within elements without end", nested(10000),
       "m.osim: nests its elements too deeply; expected at most 200 levels"},
      {"no bodies", "<OpenSimDocument Version=\"40000\">\n<Model/></OpenSimDocument>",
       "m.osim:2: the model has no bodies; expected at least one <Body> in its <BodySet>. Name a "
       "model that has bodies."},
  };
}

std::vector<Case> body_cases() {
  Parts second_joint, no_ground, circle;
  second_joint.joints[2] = Parts::pin("j3", "ground", "b", "q3");
  circle.joints = {Parts::pin("j1", "b", "a", "q1"), Parts::pin("j2", "a", "b", "q2"), ""};
  const auto inertia = [](const char* values) {
    return with_body(
        Parts::body("c", std::string("<mass>1</mass><inertia>") + values + "</inertia>"));
  };
  return {
      {"negative mass", with_body(Parts::body("c", "<mass>-1</mass>")),
       "m.osim:6: the mass of body 'c' is unusable; expected 0 or more kilograms, found -1. "
       "Correct the mass."},
      {"a mass that is no number", with_body(Parts::body("c", "<mass>1,5</mass>")),
       "m.osim:6: <mass> holds a word that is no number; expected numbers separated by spaces, "
       "found 1,5. Correct the value."},
      {"two masses", with_body(Parts::body("c", "<mass>1 2</mass>")),
       "m.osim:6: <mass> has the wrong number of values; expected 1, found 2. Give one number."},
      {"too few moments of inertia", inertia("1 1 1"),
       "m.osim:6: <inertia> of body 'c' has the wrong number of values; expected 6 (xx yy zz xy xz "
       "yz), found 3. Give all six."},
      {"an inertia that is not finite", inertia("1 1 nan 0 0 0"),
       "m.osim:6: the inertia of body 'c' is not finite; expected six finite numbers. Correct the "
       "inertia."},
      {"a mass centre with two numbers",
       with_body(Parts::body("c", "<mass>1</mass><mass_center>0 1</mass_center>")),
       "m.osim:6: <mass_center> has the wrong number of values; expected 3, found 2. Give x, y and "
       "z."},
      {"a mass centre that is not finite",
       with_body(Parts::body("c", "<mass>1</mass><mass_center>0 inf 0</mass_center>")),
       "m.osim:6: the mass properties of body 'c' are unusable; expected finite numbers, mass 0 or "
       "more. Correct mass, mass centre or inertia."},
      {"two bodies of one name", with_body(Parts::body("a")),
       "m.osim:6: two bodies are called 'a'; expected unique names. Rename one of them."},
      {"a body without a name", with_body("<Body><mass>1</mass></Body>"),
       "m.osim:6: a body has no name; expected a name attribute. Name the body."},
      {"something else among the bodies", with_body("<Ellipsoid name=\"c\"/>"),
       "m.osim:6: <Ellipsoid> in the BodySet is not supported; expected <Body>, found Ellipsoid. "
       "Replace it by a plain Body."},
      {"a body on two joints", document(second_joint),
       "m.osim:10: body 'b' is the child of two joints, 'j2' and 'j3'; expected one joint a body. "
       "Close the loop with a WeldConstraint or PointConstraint instead, or swap parent and child "
       "of one of them."},
      {"joints in a circle", document(circle),
       "m.osim:8: the joints of 'a' never reach ground (a <- b <- a); expected a chain of joints "
       "that starts at ground, without a circle. Correct a parent."},
  };
}

std::vector<Case> joint_cases() {
  const std::string sockets = Parts::sockets("a", "b");
  return {
      {"an unknown parent", with_joint(Parts::pin("j2", "/bodyset/thigh", "b", "q2")),
       "m.osim:9: <PinJoint> 'j2' refers to a body or frame that the model does not have; expected "
       "the name of a body, ground or an offset frame, found /bodyset/thigh. Correct the name or "
       "add the body."},
      {"no parent", with_joint("<PinJoint name=\"j2\"/>"),
       "m.osim:9: joint 'j2' names no parent_frame; expected <socket_parent_frame> with a body or "
       "frame. Name the body that the joint connects there."},
      {"ground as child", with_joint(Parts::pin("j2", "b", "ground", "q2")),
       "m.osim:9: joint 'j2' has ground as its child; expected a child that moves. Swap its parent "
       "and child."},
      {"a body joined to itself", with_joint(Parts::pin("j2", "b", "b", "q2")),
       "m.osim:9: the joints of 'b' never reach ground (b <- b); expected a chain of joints that "
       "starts at ground, without a circle. Correct a parent."},
      {"an unknown kind of joint", with_joint("<ScapulothoracicJoint name=\"j2\"/>"),
       "m.osim:9: <ScapulothoracicJoint> is a kind of joint that is not supported; expected "
       "WeldJoint, PinJoint, SliderJoint, UniversalJoint, BallJoint, GimbalJoint, PlanarJoint, "
       "FreeJoint, EllipsoidJoint or CustomJoint. Rewrite it as a CustomJoint."},
      {"a joint of a body that is not there",
       old_document("<PinJoint name=\"j\"><parent_body>thigh</parent_body></PinJoint>"),
       "m.osim:5: <PinJoint> 'j' refers to a body or frame that the model does not have; expected "
       "the name of a body, ground or an offset frame, found thigh. Correct the name or add the "
       "body."},
      {"an old joint without a parent", old_document("<PinJoint name=\"j\"/>"),
       "m.osim:5: joint 'j' names no parent; expected <parent_body> with a body's name. Name the "
       "body that the joint hangs on, or ground."},
      {"a reversed joint",
       old_document("<PinJoint name=\"j\"><parent_body>ground</parent_body>"
                    "<reverse>true</reverse></PinJoint>"),
       "m.osim:5: joint 'j' is reversed; expected <reverse> false, found true. Swap its parent and "
       "child."},
      {"neither true nor false",
       with_joint("<PinJoint name=\"j2\">" + sockets +
                  Parts::coordinate("q2", "<locked>yes</locked>") + "</PinJoint>"),
       "m.osim:9: <locked> is neither true nor false; expected true or false, found yes. Correct "
       "the value."},
      {"a range upside down",
       with_joint("<PinJoint name=\"j2\">" + sockets +
                  Parts::coordinate("q2", "<range>1 -1</range>") + "</PinJoint>"),
       "m.osim:9: the range of coordinate 'q2' is unusable; expected two numbers, the lower first, "
       "found 1 -1. Correct the range."},
      {"a default that is not finite",
       with_joint("<PinJoint name=\"j2\">" + sockets +
                  Parts::coordinate("q2", "<default_value>nan</default_value>") + "</PinJoint>"),
       "m.osim:9: coordinate 'q2' has an unusable default; expected a finite number, found nan. "
       "Correct the value."},
      {"two coordinates of one name in a joint",
       with_joint("<UniversalJoint name=\"j2\">" + sockets +
                  "<coordinates><Coordinate name=\"q\"/><Coordinate name=\"q\"/></coordinates>"
                  "</UniversalJoint>"),
       "m.osim:9: joint 'j2' has two coordinates called 'q'; expected unique names. Rename one of "
       "them."},
      {"too many coordinates",
       with_joint("<PinJoint name=\"j2\">" + sockets +
                  "<coordinates><Coordinate name=\"q2\"/><Coordinate name=\"q3\"/></coordinates>"
                  "</PinJoint>"),
       "m.osim:9: joint 'j2' has too many coordinates; expected 1, found 2. Remove coordinates, or "
       "use a CustomJoint."},
      {"an ellipsoid without radii",
       with_joint("<EllipsoidJoint name=\"j2\">" + sockets + "</EllipsoidJoint>"),
       "m.osim:9: ellipsoid joint 'j2' has unusable radii; expected three positive numbers in "
       "<radii_x_y_z>. Give the radii in metres."},
      {"frames on frames in a circle",
       with_joint("<PinJoint name=\"j2\">" + Parts::sockets("f", "b") +
                  "<frames><PhysicalOffsetFrame name=\"f\"><socket_parent>g</socket_parent>"
                  "</PhysicalOffsetFrame><PhysicalOffsetFrame name=\"g\"><socket_parent>f"
                  "</socket_parent></PhysicalOffsetFrame></frames></PinJoint>"),
       "m.osim:9: the frames around 'g' refer to each other in a circle; expected a chain of "
       "frames that ends at a body. Correct a frame's parent."},
      {"an offset frame on a body that is not there",
       with_joint("<PinJoint name=\"j2\">" + Parts::sockets("f", "b") +
                  "<frames><PhysicalOffsetFrame name=\"f\"><socket_parent>/bodyset/x"
                  "</socket_parent></PhysicalOffsetFrame></frames></PinJoint>"),
       "m.osim:9: <PhysicalOffsetFrame> 'f' refers to a body or frame that the model does not "
       "have; expected the name of a body, ground or an offset frame, found /bodyset/x. Correct "
       "the name or add the body."},
      {"an offset that is not finite",
       with_joint("<PinJoint name=\"j2\">" + Parts::sockets("f", "b") +
                  "<frames><PhysicalOffsetFrame name=\"f\"><socket_parent>/bodyset/a"
                  "</socket_parent><translation>0 nan 0</translation></PhysicalOffsetFrame>"
                  "</frames></PinJoint>"),
       "m.osim:9: a frame of joint 'j2' is not finite; expected finite numbers. Correct the "
       "location and orientation of its frames."},
  };
}

std::vector<Case> function_cases() {
  const auto spline = [](const char* x, const char* y) {
    return with_function(std::string("<SimmSpline><x>") + x + "</x><y>" + y + "</y></SimmSpline>");
  };
  return {
      {"an axis that is not finite", with_axis("<axis>nan 0 0</axis>"),
       "m.osim:9: an axis of joint 'j2' has no direction; expected a vector that is not zero, "
       "found nan 0 0. Give the axis a direction."},
      {"an axis of no length", with_axis("<axis>0 0 0</axis>"),
       "m.osim:9: an axis of joint 'j2' has no direction; expected a vector that is not zero, "
       "found 0 0 0. Give the axis a direction."},
      {"an axis of two numbers", with_axis("<axis>1 0</axis>"),
       "m.osim:9: <axis> has the wrong number of values; expected 3, found 2. Give x, y and z."},
      {"an axis of two coordinates", with_axis("<coordinates>q2 q3</coordinates>"),
       "m.osim:9: an axis of joint 'j2' depends on 2 coordinates; expected at most one, found q2 "
       "q3. Functions of several coordinates are not supported."},
      {"an unknown function", with_function("<ExpressionBasedFunction/>"),
       "m.osim:9: <ExpressionBasedFunction> is a kind of function that is not supported; expected "
       "Constant, LinearFunction, PolynomialFunction, Sine, SimmSpline, GCVSpline, "
       "PiecewiseLinearFunction, PiecewiseConstantFunction, StepFunction or MultiplierFunction. "
       "Replace it by a spline through its values."},
      {"x that goes down", spline("0 2 1", "0 0 0"),
       "m.osim:9: SimmSpline has x = 1 after 2 at point 3; expected x to increase. Correct the "
       "function's values."},
      {"more x than y", spline("0 1 2", "0 0"),
       "m.osim:9: SimmSpline has 3 x and 2 y values; expected as many of each. Correct the "
       "function's values."},
      {"one point", spline("0", "0"),
       "m.osim:9: SimmSpline has 1 points; expected at least 2. Correct the function's values."},
      {"no points", with_function("<SimmSpline/>"),
       "m.osim:9: <SimmSpline> has no <x>; expected a <x> element with its values. Add the "
       "values."},
      {"a line of three coefficients",
       with_function("<LinearFunction><coefficients>1 2 3</coefficients></LinearFunction>"),
       "m.osim:9: <LinearFunction> has the wrong number of coefficients; expected 2 (slope and "
       "intercept), found 3. Use a PolynomialFunction for higher powers."},
      {"a multiplier of nothing", with_function("<MultiplierFunction/>"),
       "m.osim:9: <MultiplierFunction> has no function in it; expected a <function> element with a "
       "function such as SimmSpline. Add the function."},
      {"a spline that smooths",
       with_function("<GCVSpline><half_order>2</half_order><error_variance>0.1</error_variance>"
                     "<x>0 1 2 3</x><y>0 1 0 1</y></GCVSpline>"),
       "m.osim:9: a <GCVSpline> that smooths its points is not supported; expected "
       "<error_variance> 0, found 0.1. Replace y by the smoothed values."},
      {"two parallel axes",
       with_joint("<CustomJoint name=\"j2\">" + Parts::sockets("a", "b") +
                  "<SpatialTransform><TransformAxis name=\"rotation1\"><axis>1 0 0</axis>"
                  "</TransformAxis><TransformAxis name=\"rotation2\"><axis>-2 0 0</axis>"
                  "</TransformAxis></SpatialTransform></CustomJoint>"),
       "m.osim:9: two rotation axes of joint 'j2' are parallel; expected three axes in different "
       "directions. Correct an axis."},
  };
}

std::vector<Case> reference_cases() {
  return {
      {"a coupler of an unknown coordinate", with_constraints(coupler("c", "q1", "q9")),
       "m.osim:12: <CoordinateCouplerConstraint> 'c' refers to a coordinate that the model does "
       "not have; expected the name of a coordinate, found q9. Correct the name."},
      {"a coupler without a function",
       with_constraints("<CoordinateCouplerConstraint name=\"c\"><independent_coordinate_names>q1"
                        "</independent_coordinate_names><dependent_coordinate_name>q2"
                        "</dependent_coordinate_name></CoordinateCouplerConstraint>"),
       "m.osim:12: coupler 'c' has no function; expected <coupled_coordinates_function> with a "
       "function in it. Add the function."},
      {"a coupler of two coordinates", with_constraints(coupler("c", "q1 q2", "q2")),
       "m.osim:12: coupler 'c' has the wrong number of independent coordinates; expected 1, found "
       "2. Functions of several coordinates are not supported."},
      {"couplers in a circle",
       with_constraints(coupler("c", "q1", "q2") + coupler("d", "q2", "q1")),
       "m.osim:12: coupler 'c' makes coordinate 'q2' depend on itself; expected couplers without a "
       "circle. Remove a coupler."},
      {"two couplers of one coordinate",
       with_constraints(coupler("c", "q1", "q2") + coupler("d", "q1", "q2")),
       "m.osim:12: two couplers set coordinate 'q2'; expected one coupler a coordinate, found "
       "another in 'd'. Remove one of them."},
      {"a weld to a body that is not there",
       with_constraints("<WeldConstraint name=\"w\"><socket_frame1>/bodyset/a</socket_frame1>"
                        "<socket_frame2>/bodyset/z</socket_frame2></WeldConstraint>"),
       "m.osim:12: <WeldConstraint> 'w' refers to a body or frame that the model does not have; "
       "expected the name of a body, ground or an offset frame, found /bodyset/z. Correct the name "
       "or add the body."},
      {"a point constraint without bodies", with_constraints("<PointConstraint name=\"p\"/>"),
       "m.osim:12: constraint 'p' names no body_1; expected <socket_body_1> or <body_1> with a "
       "body. Name the body, or disable the constraint."},
      {"a marker on a body that is not there", with_markers(marker("RASI", "/bodyset/pelvis")),
       "m.osim:12: <Marker> 'RASI' refers to a body or frame that the model does not have; "
       "expected the name of a body, ground or an offset frame, found /bodyset/pelvis. Correct the "
       "name or add the body."},
      {"a marker without a body", with_markers("<Marker name=\"RASI\"/>"),
       "m.osim:12: marker 'RASI' names no body; expected <socket_parent_frame> or <body> with a "
       "body's name. Name the body that carries the marker."},
      {"a marker that is nowhere", with_markers(marker("RASI", "a", "0 0 nan")),
       "m.osim:12: marker 'RASI' has an unusable place; expected a body and three finite numbers. "
       "Correct its location."},
      {"a word in a place", with_markers(marker("RASI", "a", "0 0 zero")),
       "m.osim:12: <location> holds a word that is no number; expected numbers separated by "
       "spaces, found zero. Correct the value."},
      {"two markers of one name", with_markers(marker("RASI", "a") + marker("RASI", "b")),
       "m.osim:12: two markers are called 'RASI'; expected unique names. Rename one of them."},
      {"a path point on a body that is not there",
       with_path(point("p1", "a") + point("p2", "/bodyset/radius")),
       "m.osim:12: <PathPoint> 'p2' refers to a body or frame that the model does not have; "
       "expected the name of a body, ground or an offset frame, found /bodyset/radius. Correct the "
       "name or add the body."},
      {"a path of one point", with_path(point("p1", "a")),
       "m.osim:12: the path of 'biceps' has too few points; expected 2 or more, found 1. Add "
       "points, or remove the muscle."},
      {"an unknown kind of path point", with_path("<SurfacePoint name=\"p\"/>" + point("p2", "a")),
       "m.osim:12: <SurfacePoint> is a kind of path point that is not supported; expected "
       "PathPoint, ConditionalPathPoint or MovingPathPoint. Replace it by a PathPoint."},
      {"a condition without a range",
       with_path("<ConditionalPathPoint name=\"p\"><socket_parent_frame>a</socket_parent_frame>"
                 "<socket_coordinate>q1</socket_coordinate></ConditionalPathPoint>" +
                 point("p2", "a")),
       "m.osim:12: conditional path point 'p' has an unusable range; expected two numbers in "
       "<range>. Give the coordinate's lowest and highest value on the path."},
      {"gravity of one number", with_rest("<gravity>9.81</gravity>"),
       "m.osim:12: <gravity> has the wrong number of values; expected 3, found 1. Give x, y and "
       "z."},
  };
}

void expect_errors(const std::vector<Case>& cases) {
  for (const Case& c : cases) EXPECT_EQ(error_of(c.content), c.error) << c.what;
}

TEST(MalformedOsim, IsNamedWhereTheFileIsNoModel) { expect_errors(file_cases()); }
TEST(MalformedOsim, IsNamedInBodies) { expect_errors(body_cases()); }
TEST(MalformedOsim, IsNamedInJoints) { expect_errors(joint_cases()); }
TEST(MalformedOsim, IsNamedInFunctions) { expect_errors(function_cases()); }
TEST(MalformedOsim, IsNamedInReferences) { expect_errors(reference_cases()); }

TEST(MalformedOsim, StartsFromADocumentThatIsWellFormed) {
  EXPECT_EQ(error_of(document({})), "no error");
}

// Cut anywhere, a model is an error; it never reads as less than it is.
TEST(MalformedOsim, IsReportedWhereverAFileIsCut) {
  const std::string whole = with_constraints(coupler("c", "q1", "q2"));
  for (std::size_t size = 0; size + 1 < whole.size(); ++size) {  // the line's end may be missing
    EXPECT_NE(error_of(whole.substr(0, size)), "no error") << size;
  }
}

std::string warnings_of(const std::string& content) {
  std::string text;
  for (const Warning& warning : parse_osim("m.osim", content).warnings) {
    text += to_string(warning) + "\n";
  }
  return text;
}

TEST(OsimWarnings, TellWhatWasUnderstoodOtherwise) {
  EXPECT_EQ(warnings_of(document({})), "");
  EXPECT_EQ(warnings_of(with_body(Parts::body("c"))),
            "m.osim:6: no joint carries body 'c'; it is left free in ground\n");
  EXPECT_EQ(warnings_of(with_joint(Parts::pin("j1", "a", "b", "q1"))),
            "m.osim:9: another joint is called 'j1' too; this one is called 'j1_2' here\n"
            "m.osim:9: another joint has a coordinate called 'q1' too; this one is called "
            "'j1_2/q1' here and in results\n");
  EXPECT_EQ(warnings_of(with_axis("<coordinates>q2</coordinates>")),
            "m.osim:9: an axis of joint 'j2' names coordinate 'q2' but no function; the coordinate "
            "does not move it, as in OpenSim 4\n");
  EXPECT_EQ(warnings_of(with_constraints("<RollingOnSurfaceConstraint name=\"r\"/>")),
            "m.osim:12: <RollingOnSurfaceConstraint> 'r' is not supported: it will not be kept\n");
}

TEST(OsimFile, FollowsEveryWayToReferToAFrame) {
  const std::string frames =
      "<frames><PhysicalOffsetFrame name=\"f\"><socket_parent>/bodyset/a</socket_parent>"
      "<translation>1 0 0</translation>"
      "<frames><PhysicalOffsetFrame name=\"g\"><socket_parent>..</socket_parent>"
      "<translation>0 2 0</translation></PhysicalOffsetFrame></frames>"
      "</PhysicalOffsetFrame></frames>";
  for (const char* reference : {"g", "../j2/f/g", "/jointset/j2/f/g", "f/g"}) {
    const MusculoskeletalModel model =
        parse_osim("m.osim", with_joint("<PinJoint name=\"j2\">" + Parts::sockets(reference, "b") +
                                        frames + "</PinJoint>"));
    EXPECT_EQ(model.joints[1].parent, 1) << reference;
    EXPECT_EQ(model.joints[1].X_PF.p, Eigen::Vector3d(1, 2, 0)) << reference;
  }
  for (const char* reference : {"a", "/bodyset/a", "../../bodyset/a", "/m/bodyset/a"}) {
    EXPECT_EQ(parse_osim("m.osim", with_markers(marker("RASI", reference))).markers[0].body, 1);
  }
}

TEST(OsimFile, FindsCoordinatesByNameAndByPath) {
  const std::string second = Parts::pin("j2", "a", "b", "q1");  // q1, as that of j1
  Parts parts;
  parts.joints[1] = second;
  for (const auto& [reference, index] :
       {std::pair{"q1", 0}, {"/jointset/j1/q1", 0}, {"/jointset/j2/q1", 1}, {"j2/q1", 1}}) {
    const bool first = index == 0;
    parts.rest = "<ConstraintSet><objects>" + coupler("c", reference, first ? "j2/q1" : "q1") +
                 "</objects></ConstraintSet>";
    EXPECT_EQ(parse_osim("m.osim", document(parts)).couplers[0].independent, index) << reference;
  }
}

TEST(OsimFile, MultipliesTheFactorsOfCouplersAndMultipliers) {
  const MusculoskeletalModel model = parse_osim(
      "m.osim",
      with_constraints(
          "<CoordinateCouplerConstraint name=\"c\"><independent_coordinate_names>q1"
          "</independent_coordinate_names><dependent_coordinate_name>q2</dependent_coordinate_name>"
          "<coupled_coordinates_function><MultiplierFunction><function><MultiplierFunction><"
          "function>"
          "<Constant><value>7</value></Constant></function><scale>2</scale></MultiplierFunction>"
          "</function><scale>3</scale></MultiplierFunction></coupled_coordinates_function>"
          "<scale_factor>5</scale_factor></CoordinateCouplerConstraint>"));
  EXPECT_EQ(CompiledFunction(model.couplers[0].function).value(0.0), 210.0);
}

TEST(OsimFile, ReadsFunctionsWithOpenSimsStandardValues) {
  const auto function = [](const std::string& text) {
    return CompiledFunction(parse_osim("m.osim", with_function(text)).joints[1].axes[0].function);
  };
  EXPECT_TRUE(function("<LinearFunction/>").is_identity());
  EXPECT_EQ(function("<Constant/>").value(1.0), 0.0);
  EXPECT_EQ(function("<Sine/>").value(1.0), std::sin(1.0));
  const CompiledFunction step = function(
      "<StepFunction><transition_start_time>1</transition_start_time><transition_end_time>3"
      "</transition_end_time><start_value>2</start_value><end_value>4</end_value></StepFunction>");
  EXPECT_EQ(step.value(0.0), 2.0);
  EXPECT_NEAR(step.value(2.0), 3.0, 1e-15);
}

// Before version 10901 a joint lists only the axes that move.
TEST(OsimFile, ReadsTheAxesOfTheOldestJoints) {
  const std::string text =
      "<CustomJoint name=\"j\"><parent_body>ground</parent_body><CoordinateSet><objects>"
      "<Coordinate name=\"q\"/></objects></CoordinateSet><TransformAxisSet><objects>"
      "<TransformAxis><is_rotation>true</is_rotation><coordinate>q</coordinate><axis>0 0 1</axis>"
      "<function><LinearFunction/></function></TransformAxis></objects></TransformAxisSet>"
      "</CustomJoint>";
  const MusculoskeletalModel model = parse_osim("m.osim", old_document(text));
  const Joint& joint = model.joints[0];
  EXPECT_EQ(joint.axes[0].axis, Eigen::Vector3d(0, 0, 1));
  EXPECT_EQ(joint.axes[0].coordinate, 0);
  EXPECT_EQ(model.coordinates[0].motion, Coordinate::Motion::kRotational);
}

}  // namespace
}  // namespace sinew
