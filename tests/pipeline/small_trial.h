#pragma once

#include <Eigen/Core>
#include <cmath>
#include <filesystem>
#include <numbers>
#include <string>

#include "data/storage_file.h"
#include "data/trc_file.h"
#include "tests/data/test_files.h"

namespace sinew {

/// A trunk that moves in the plane and a thigh that swings from it, with three markers on each: a
/// model, a recording without noise and its truth, small enough to be told in closed form.
struct SmallTrial {
  static constexpr int kFrames = 151;
  static constexpr double kStep = 0.01;  // [s]

  struct Pose {
    double tilt, x, y, hip;  // [rad, m, m, rad]
  };

  static Pose pose(double t) {
    const double w = 2.0 * std::numbers::pi;
    return {0.1 * std::sin(w * t), 1.2 * t, 1.0 + 0.02 * std::cos(2.0 * w * t),
            0.4 * std::sin(w * t + 0.5)};
  }

  static std::string model() {
    std::string markers;
    for (const auto& [name, body, p] : kMarkers) {
      markers += "<Marker name=\"" + std::string(name) + "\"><socket_parent_frame>/bodyset/" +
                 body + "</socket_parent_frame><location>" + text(p[0]) + " " + text(p[1]) + " " +
                 text(p[2]) + "</location></Marker>\n";
    }
    return R"(<OpenSimDocument Version="40000">
<Model name="swing">
<gravity>0 -9.80665 0</gravity>
<BodySet><objects>
<Body name="trunk"><mass>40</mass><mass_center>0 0.3 0</mass_center><inertia>2 1 2 0 0 0</inertia></Body>
<Body name="thigh"><mass>8</mass><mass_center>0 -0.2 0</mass_center><inertia>0.1 0.03 0.1 0 0 0</inertia></Body>
</objects></BodySet>
<JointSet><objects>
<PlanarJoint name="floor"><socket_parent_frame>ground</socket_parent_frame><socket_child_frame>trunk</socket_child_frame>
<coordinates><Coordinate name="tilt"/><Coordinate name="x"/><Coordinate name="y"/></coordinates></PlanarJoint>
<PinJoint name="hip"><socket_parent_frame>trunk</socket_parent_frame><socket_child_frame>thigh</socket_child_frame>
<coordinates><Coordinate name="flexion"/></coordinates></PinJoint>
</objects></JointSet>
<MarkerSet><objects>
)" + markers +
           "</objects></MarkerSet>\n</Model>\n</OpenSimDocument>\n";
  }

  static MarkerTrajectories recording(int frames = kFrames) {
    MarkerTrajectories markers;
    markers.rate = 1.0 / kStep;
    markers.time.resize(frames);
    markers.p_WM.resize(frames, 3 * 6);
    for (const auto& marker : kMarkers) markers.names.emplace_back(marker.name);
    for (int frame = 0; frame < frames; ++frame) {
      const double t = frame * kStep;
      const Pose q = pose(t);
      markers.frame_numbers.push_back(frame + 1);
      markers.time[frame] = t;
      for (int m = 0; m < 6; ++m) {
        const Eigen::Vector3d p(kMarkers[m].p);
        const bool on_thigh = std::string(kMarkers[m].body) == "thigh";
        const double turn = q.tilt + (on_thigh ? q.hip : 0.0);
        markers.p_WM(frame, 3 * m) = q.x + std::cos(turn) * p[0] - std::sin(turn) * p[1];
        markers.p_WM(frame, 3 * m + 1) = q.y + std::sin(turn) * p[0] + std::cos(turn) * p[1];
        markers.p_WM(frame, 3 * m + 2) = p[2];
      }
    }
    // Hidden for a while, so that counts of measured frames differ.
    if (frames > 20) markers.p_WM.block(10, 3 * 4, 5, 3).setConstant(kMissing);
    return markers;
  }

  /// A force that holds the body's weight, at the thigh's far end, for these times.
  static TimeTable loads(double from, double to) {
    TimeTable table;
    table.name = "grf";
    table.labels = {"f_vx", "f_vy",       "f_vz",       "f_px",      "f_py",
                    "f_pz", "f_torque_x", "f_torque_y", "f_torque_z"};
    const int rows = static_cast<int>(std::round((to - from) / 0.005)) + 1;
    table.time = Eigen::VectorXd::LinSpaced(rows, from, to);
    table.values = RowMatrix::Zero(rows, 9);
    for (int row = 0; row < rows; ++row) {
      table.values(row, 1) = 48.0 * 9.80665;
      table.values(row, 3) = 1.2 * table.time[row];
    }
    return table;
  }

  static std::string loads_setup(const std::string& data_file) {
    return R"(<OpenSimDocument Version="40000">
<ExternalLoads name="loads"><objects>
<ExternalForce name="push"><applied_to_body>thigh</applied_to_body>
<force_expressed_in_body>ground</force_expressed_in_body><point_expressed_in_body>ground</point_expressed_in_body>
<force_identifier>f_v</force_identifier><point_identifier>f_p</point_identifier><torque_identifier>f_torque_</torque_identifier></ExternalForce>
</objects>
<datafile>)" +
           data_file + "</datafile>\n</ExternalLoads></OpenSimDocument>\n";
  }

  static std::string tasks() {
    std::string text = "<IKTaskSet><objects>\n";
    for (const auto& marker : kMarkers) {
      text += "<IKMarkerTask name=\"" + std::string(marker.name) +
              "\"><apply>true</apply><weight>2</weight></IKMarkerTask>\n";
    }
    return text + "</objects></IKTaskSet>\n";
  }

  /// model.osim, walk.trc, grf.mot, grf.xml and tasks.xml.
  static void write(const TemporaryFolder& folder) {
    folder.write("model.osim", model());
    write_trc(folder.path() / "walk.trc", recording());
    write_storage(folder.path() / "grf.mot", loads(0.0, (kFrames - 1) * kStep));
    folder.write("grf.xml", loads_setup("grf.mot"));
    folder.write("tasks.xml", tasks());
  }

 private:
  struct Place {
    const char* name;
    const char* body;
    double p[3];  // [m]
  };
  static constexpr Place kMarkers[6] = {
      {"T1", "trunk", {0.1, 0.4, 0.1}},     {"T2", "trunk", {-0.1, 0.4, 0.05}},
      {"T3", "trunk", {0.0, 0.1, -0.1}},    {"L1", "thigh", {0.05, -0.1, 0.1}},
      {"L,2", "thigh", {-0.05, -0.3, 0.1}}, {"L3", "thigh", {0.0, -0.4, 0.12}}};
  static constexpr double kMissing = std::numeric_limits<double>::quiet_NaN();

  static std::string text(double x) { return std::to_string(x); }
};

}  // namespace sinew
