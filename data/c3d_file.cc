#include "data/c3d_file.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>
#include <utility>

#include "data/c3d_reader.h"

namespace sinew {

int C3dAnalog::find_channel(const std::string& label) const {
  const auto found = std::find(labels.begin(), labels.end(), label);
  return found == labels.end() ? -1 : static_cast<int>(found - labels.begin());
}

double C3dFile::start_time() const {
  // Some files count frames from 0; their events do not.
  const auto before = static_cast<double>(std::max<std::int64_t>(layout.first_frame - 1, 0));
  return layout.rate > 0.0 ? before / layout.rate : 0.0;
}

C3dFile read_c3d(const std::filesystem::path& path, std::int64_t max_frames) {
  C3dReader reader(path);
  C3dFrames frames;
  const auto limit = std::min<std::int64_t>(max_frames, std::numeric_limits<int>::max());
  const int count = reader.read(static_cast<int>(limit), frames);
  C3dFile file = reader.description();
  file.layout.frames = count;
  file.quality = std::move(frames.quality);
  file.computed.values = std::move(frames.computed);
  file.analog.values = std::move(frames.analog);
  file.markers.p_WM = std::move(frames.p_WM);
  file.markers.rate = file.layout.rate;
  file.markers.time.resize(count);
  file.markers.frame_numbers.resize(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    file.markers.time[i] = i / file.layout.rate;
    file.markers.frame_numbers[static_cast<std::size_t>(i)] =
        static_cast<int>(file.layout.first_frame) + i;
  }
  return file;
}

std::optional<Eigen::Matrix3d> rotation_to_y_up(const C3dFile& file) {
  if (!file.screen) return std::nullopt;
  Eigen::Matrix3d R;
  R.row(0) = file.screen->x;
  R.row(1) = file.screen->y;
  R.row(2) = file.screen->x.cross(file.screen->y);
  return R;
}

}  // namespace sinew
