#include "ik/marker_placement.h"

#include <gtest/gtest.h>

#include "tests/data/test_files.h"
#include "tests/ik/walker.h"

namespace sinew {
namespace {

using Eigen::Vector3d;

// The walker's markers in its default pose, shifted a little from where the model has them.
MarkerFile recording_of(const Walker& walker, double shift) {
  KinematicWorkspace ws(walker.tree);
  update_poses(walker.tree, ws);
  MarkerFile file;
  file.path = "static.trc";
  MarkerTrajectories& markers = file.markers;
  markers.rate = 100.0;
  markers.time = Eigen::VectorXd::LinSpaced(5, 0.0, 0.04);
  markers.frame_numbers = {1, 2, 3, 4, 5};
  const auto n = static_cast<Eigen::Index>(walker.model.markers.size());
  markers.p_WM.resize(5, 3 * n);
  for (Eigen::Index m = 0; m < n; ++m) {
    const Marker& marker = walker.model.markers[static_cast<std::size_t>(m)];
    markers.names.push_back(marker.name);
    const Vector3d p = ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM;
    for (int frame = 0; frame < 5; ++frame) {
      // Swaying about the mean, which is shifted along x for every other marker.
      const double x = 0.01 * (frame - 2) + (m % 2 == 0 ? shift : -shift);
      markers.p_WM.row(frame).segment<3>(3 * m) = (p + Vector3d(x, 0, 0)).transpose();
    }
  }
  return file;
}

TEST(PlaceMarkers, PutsThemWhereTheyWereMeasured) {
  Walker walker;
  walker.model.markers[1].fixed = true;
  const MarkerFile trial = recording_of(walker, 0.004);
  const MarkerPlacementResult result = place_markers(walker.model, trial, nullptr, nullptr);
  EXPECT_TRUE(converged(result.termination));
  EXPECT_EQ(result.frames, 5);
  const KinematicTree tree = compile_tree(result.model);
  KinematicWorkspace ws(tree);
  for (std::size_t c = 0; c < tree.q_of_coordinate.size(); ++c) {
    ws.q[static_cast<std::size_t>(tree.q_of_coordinate[c])] =
        result.coordinates[static_cast<Eigen::Index>(c)];
  }
  update_poses(tree, ws);
  const MarkerTrajectories mean = average_frames(trial.markers, 0, 4);
  for (std::size_t m = 0; m < result.model.markers.size(); ++m) {
    const Marker& marker = result.model.markers[m];
    const Vector3d p = ws.X_WB[static_cast<std::size_t>(marker.body)] * marker.p_BM;
    const double distance = (p - mean.position(0, static_cast<int>(m))).norm();
    if (m == 1) {
      EXPECT_EQ(marker.p_BM, walker.model.markers[1].p_BM);
      EXPECT_EQ(result.markers[1].fate, PlacedMarker::Fate::kFixed);
      EXPECT_NEAR(result.markers[1].distance, distance, 1e-9);
    } else {
      EXPECT_LT(distance, 1e-12) << marker.name;
    }
  }
  EXPECT_GT(result.marker_rms, 1e-3);
  EXPECT_LT(result.marker_rms, 4e-3);
}

TEST(PlaceMarkers, KeepsWhatIsNotSeenAndRemovesWhatIsNotRecorded) {
  Walker walker;
  MarkerFile trial = recording_of(walker, 0.0);
  trial.markers.names[2] = "somewhere else";
  trial.markers.p_WM.middleCols(9, 3).setConstant(kNaN);
  const MarkerPlacementResult result = place_markers(walker.model, trial, nullptr, nullptr);
  EXPECT_EQ(result.markers[2].fate, PlacedMarker::Fate::kRemoved);
  EXPECT_EQ(result.markers[3].fate, PlacedMarker::Fate::kNotMeasured);
  EXPECT_EQ(result.model.markers.size(), walker.model.markers.size() - 1);
  EXPECT_EQ(result.model.markers[2].p_BM, walker.model.markers[3].p_BM);
}

TEST(PlaceMarkers, WarnsOfMovement) {
  const Walker walker;
  MarkerPlacementOptions options;
  options.max_marker_movement = 0.03;
  const MarkerFile trial = recording_of(walker, 0.0);
  const MarkerPlacementResult result =
      place_markers(walker.model, trial, nullptr, nullptr, options);
  EXPECT_NE(to_text(result.warnings)
                .find("0: marker '" + walker.model.markers[0].name +
                      "' moves by 40.0 mm in the static trial; the limit is 30.0 mm\n"),
            std::string::npos)
      << to_text(result.warnings);
}

TEST(PlaceMarkers, RefusesOptionsOutOfBounds) {
  const Walker walker;
  const MarkerFile trial = recording_of(walker, 0.0);
  MarkerPlacementOptions options;
  options.default_weight = -1.0;
  try {
    place_markers(walker.model, trial, nullptr, nullptr, options);
    FAIL() << "accepted";
  } catch (const std::invalid_argument& error) {
    EXPECT_STREQ(error.what(), "MarkerPlacementOptions.default_weight is -1; expected 0 or more");
  }
}

}  // namespace
}  // namespace sinew
