#pragma once

#include <optional>
#include <string>
#include <vector>

#include "data/c3d_file.h"

namespace sinew::c3d {

/// Metres in a unit of length as POINT:UNITS names it, in any case and also cut short ("mete"), or
/// nothing.
std::optional<double> metres_per(const std::string& unit);

/// Which of the file's points are markers and which are computed, and what all are called.
struct PointNames {
  std::vector<int> marker_points, computed_points;  // indices of points
};

/// Fills names of markers, labels of computed trajectories and channels, their units and the screen
/// of `file`, whose groups and layout are known. Names become unique; missing ones are unnamed_1,
/// unnamed_2, ...; warns of both.
PointNames name_everything(C3dFile& file);

/// The events of header and group EVENT, on the clock of the file's first frame.
std::vector<C3dEvent> find_events(const C3dFile& file, std::vector<Warning>& warnings);

}  // namespace sinew::c3d
