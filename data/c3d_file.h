#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "data/c3d_parameters.h"
#include "data/marker_trajectories.h"

namespace sinew {

/// A named instant. Times count from the first frame of the file, as MarkerTrajectories::time does.
struct C3dEvent {
  double time = 0.0;                    // [s]
  std::string label, context, subject;  // "Foot Strike", "Left", ...
  std::string description;
  bool in_header = false;  // one of the header's 18 instead of one of the group EVENT

  bool operator==(const C3dEvent&) const = default;
};

/// The first block of a C3D file as it is stored, whether the parameters agree or not.
struct C3dHeader {
  C3dProcessor processor = C3dProcessor::kIntel;
  int parameter_block = 2;   // counted from 1, as every block
  int points = 0;            // in a frame
  int analog_per_frame = 0;  // samples of all channels in a frame
  int first_frame = 1, last_frame = 0;
  int max_gap = 0;      // frames that were interpolated
  double scale = -1.0;  // of integer coordinates; negative where data are reals
  int data_block = 0;
  int analog_ratio = 0;          // samples of a channel in a frame
  double rate = 0.0;             // frames [Hz]
  std::vector<C3dEvent> events;  // times as stored, from frame 1 on [s]

  bool operator==(const C3dHeader&) const = default;
};

/// How the data are laid out, after header, parameters and the size of the file were weighed.
struct C3dLayout {
  bool reals = true;  // numbers are 32-bit reals, else 16-bit integers
  int points = 0;     // in a frame
  int analog_channels = 0;
  int analog_ratio = 0;          // samples of a channel in a frame
  std::int64_t frames = 0;       // whole ones in the file
  std::int64_t first_frame = 1;  // number of the first
  double rate = 0.0;             // frames [Hz]
  double scale = 1.0;            // of integer coordinates and of residuals, in the file's unit
  std::uint64_t data_offset = 0, frame_bytes = 0;

  bool operator==(const C3dLayout&) const = default;
};

/// Trajectories that are no positions: joint angles, moments and powers that some systems store
/// among the points (POINT:ANGLES, FORCES, MOMENTS, POWERS, ...).
struct C3dComputed {
  std::vector<std::string> labels, kinds, units;  // a kind is its parameter's name; units as stored
  RowMatrix values;                               // frames × 3·labels; NaN = missing

  int count() const { return static_cast<int>(labels.size()); }
};

/// Analog channels: forces, EMG, ...
struct C3dAnalog {
  std::vector<std::string> labels, units;  // labels unique; units as stored
  double rate = 0.0;                       // [Hz]
  int samples_per_frame = 0;
  RowMatrix values;  // samples × channels, scaled to `units`

  int channel_count() const { return static_cast<int>(labels.size()); }
  int find_channel(const std::string& label) const;  // or -1; exact match
};

/// How each marker was measured: frames × markers.
struct C3dQuality {
  using Residuals = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  using Cameras = Eigen::Matrix<std::uint8_t, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  Residuals residual;  // mean distance of the rays [m]; 0 = made by a program; NaN = not measured
  Cameras cameras;     // bit i: camera i + 1 saw it, for the first seven
};

/// The directions in the laboratory of a screen's axes, to the right and up; POINT:X_SCREEN and
/// Y_SCREEN. Y_SCREEN is up in the laboratory.
struct C3dScreen {
  Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitZ();
};

/// All a C3D file says, in SI where it is a position. Positions stay in the laboratory's frame.
struct C3dFile {
  std::string path;
  C3dHeader header;
  C3dLayout layout;
  C3dGroups groups;
  std::string unit = "mm";  // of lengths in parameters and computed trajectories
  double metres_per_unit = 1e-3;
  std::optional<C3dScreen> screen;

  MarkerTrajectories markers;  // time 0 at the first frame
  C3dQuality quality;
  C3dComputed computed;
  C3dAnalog analog;
  std::vector<C3dEvent> events;
  std::vector<Warning> warnings;

  double start_time() const;  // of the first frame if frame 1 is at 0 [s]
};

/// Reads a whole C3D file: DEC, Intel or SGI/MIPS numbers, reals or integers. See C3dReader for
/// files that shall not lie in memory at once, and for the errors.
/// With `max_frames` only as many from the beginning, as if the file ended there.
/// O(bytes) in time; about four times the file's size in memory.
C3dFile read_c3d(const std::filesystem::path& path,
                 std::int64_t max_frames = std::numeric_limits<std::int64_t>::max());

/// The rotation from the laboratory to axes with y up and x to the right of the screen, as
/// OpenSim's models stand: multiply positions from the left. Nothing if the file does not say.
std::optional<Eigen::Matrix3d> rotation_to_y_up(const C3dFile& file);

}  // namespace sinew
