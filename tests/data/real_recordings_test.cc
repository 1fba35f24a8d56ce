#include <gtest/gtest.h>

#include <cmath>

#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

const fs::path kData = "../shared/data";

const std::string kCore = "opensim-core/";
const std::string kModels = "opensim-models/";
const std::string kBmc = "BMC/data/opensim/Mod&Sim2018/";
const std::string kArnold = "nimblephysics/Arnold2013Synthetic/";

class RealRecordings : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kData)) GTEST_SKIP() << "needs the recordings in " << kData;
  }
};

std::vector<fs::path> files_with(std::initializer_list<const char*> endings) {
  std::vector<fs::path> paths;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(kData)) {
    for (const char* ending : endings) {
      if (entry.path().extension() == ending) paths.push_back(entry.path());
    }
  }
  return paths;
}

// What was counted in the files independently of this reader; extents are in the file's unit.
struct TrcFacts {
  std::string path;
  int markers = 0, frames = 0;
  double rate = 0.0, from = 0.0, to = 0.0;
  int first_frame = 1;
  int missing = 0;
  double metres = 1e-3;  // a unit of the file
  double min_x = 0.0, max_x = 0.0, min_z = 0.0, max_z = 0.0;
};

const std::vector<TrcFacts> kTrcFacts = {
    {kCore + "Applications/IK/tests/resources/subject01_synthetic_marker_data.trc", 31, 73, 60.0,
     0.4, 1.6, 1, 0, 1.0, 0.05837, 1.068, -0.214, 0.2244},
    {kCore + "Applications/Scale/tests/resources/init100.trc", 22, 120, 120.0, 0.0, 0.992, 101, 0,
     1e-3, 114.5, 469.5, 38.42, 1313},
    {kCore + "Applications/Scale/tests/resources/subject01_static.trc", 49, 300, 60.0, 0.0, 4.983,
     1, 0, 1e-3, 366.6, 677.6, -664.3, 711.8},
    {kCore + "OpenSim/Common/Test/dataWithBlanksForMissingMarkers.trc", 40, 464, 250.0, 0.0, 1.852,
     1, 15005, 1e-3, 1146, 4302, 47.61, 1557},
    {kCore + "OpenSim/Common/Test/dataWithEformat.trc", 14, 5, 119.88012, 0.008342, 0.041708, 1, 0,
     1.0, -0.273, 0.135, -1.76, -1.3},
    {kCore + "OpenSim/Common/Test/dataWithNaNsOfDifferentCases.trc", 14, 5, 250.0, 0.0, 0.016, 1, 5,
     1e-3, -34, 311.3, 33.12, 385.2},
    {kCore + "OpenSim/Common/Test/dataWithNaNsWithSpaces.trc", 42, 427, 100.0, 0.0, 4.26, 1, 22,
     1e-3, 199.6, 1508, -679.6, 46.09},
    {kCore + "OpenSim/Common/Test/exampleFormat.trc", 3, 5, 100.0, 0.01, 0.05, 1, 2, 1.0, -0.273,
     -0.0517, -1.71, -1.57},
    {kCore + "OpenSim/Common/Test/std_walking2_markers.trc", 44, 126, 250.0, 0.0, 4.992, 1, 2809,
     1e-3, -2552, 4104, 35.7, 1730},
    {kCore + "OpenSim/Examples/Moco/example3DWalking/markers_walk.trc", 41, 238, 100.0, 0.0, 2.37,
     1, 0, 1e-3, -922, 2537, -587.8, 83.56},
    {kCore + "OpenSim/Tests/shared/gait10dof18musc_walk_CRLF_line_ending.trc", 41, 10, 60.0, 0.0,
     0.15, 1, 0, 1e-3, 93.54, 1079, -294.3, 327.5},
    {kArnold + "subject01/trials/walk2/markers.trc", 64, 223, 200.00000000000426, 3.38, 4.49, 1, 0,
     1.0, 0.5058, 2.764, -0.8012, -0.196},
    {kArnold + "subject02/trials/walk2/markers.trc", 64, 235, 200.00000000000426, 3.08, 4.25, 1, 0,
     1.0, 0.4461, 2.803, -0.8152, -0.1174},
    {kBmc + "ExpData/motion_capture_run.trc", 78, 123, 150.0, 0.0, 0.813, 1, 2460, 1e-3, -536.2,
     2342, -542, 157.6},
};

// Least and largest value of one axis over all markers.
std::pair<double, double> extent(const MarkerTrajectories& markers, int axis) {
  double least = std::numeric_limits<double>::infinity(), largest = -least;
  for (int frame = 0; frame < markers.frame_count(); ++frame) {
    for (int marker = 0; marker < markers.marker_count(); ++marker) {
      const double value = markers.position(frame, marker)[axis];
      if (std::isnan(value)) continue;
      least = std::min(least, value);
      largest = std::max(largest, value);
    }
  }
  return {least, largest};
}

int count_missing(const MarkerTrajectories& markers) {
  return static_cast<int>(markers.p_WM.array().isNaN().count()) / 3;
}

TEST_F(RealRecordings, TrcFilesHoldWhatWasCounted) {
  for (const TrcFacts& facts : kTrcFacts) {
    SCOPED_TRACE(facts.path);
    const MarkerTrajectories markers = read_trc(kData / facts.path).markers;
    EXPECT_EQ(markers.marker_count(), facts.markers);
    EXPECT_EQ(markers.frame_count(), facts.frames);
    EXPECT_EQ(markers.rate, facts.rate);
    EXPECT_EQ(markers.time[0], facts.from);
    EXPECT_EQ(markers.time[facts.frames - 1], facts.to);
    EXPECT_EQ(markers.frame_numbers[0], facts.first_frame);
    EXPECT_EQ(count_missing(markers), facts.missing);
    // The facts are rounded to four digits.
    const auto near = [&](double value, double fact) {
      EXPECT_NEAR(value, fact * facts.metres, 6e-4 * std::abs(fact) * facts.metres);
    };
    const auto [min_x, max_x] = extent(markers, 0);
    const auto [min_z, max_z] = extent(markers, 2);
    near(min_x, facts.min_x);
    near(max_x, facts.max_x);
    near(min_z, facts.min_z);
    near(max_z, facts.max_z);
  }
}

TEST_F(RealRecordings, EveryTrcFileRoundTrips) {
  const TemporaryFolder folder;
  const std::vector<fs::path> paths = files_with({".trc"});
  EXPECT_GE(paths.size(), 18u);
  for (const fs::path& path : paths) {
    SCOPED_TRACE(path);
    const MarkerFile file = read_trc(path);
    // One promises other counts, two have no end of their last row.
    const bool odd = path.filename() == "std_walking2_markers.trc" ||
                     path.filename() == "dataWithBlanksForMissingMarkers.trc" ||
                     path.filename() == "exampleFormat.trc";
    EXPECT_EQ(file.warnings.size(), odd ? 1u : 0u) << to_text(file.warnings);
    write_trc(folder.path() / "t.trc", file.markers);
    const MarkerTrajectories back = read_trc(folder.path() / "t.trc").markers;
    EXPECT_EQ(back.names, file.markers.names);
    EXPECT_EQ(back.rate, file.markers.rate);
    EXPECT_EQ(back.frame_numbers, file.markers.frame_numbers);
    // The file's own name stands in it.
    write_trc(folder.path() / "again/t.trc", back);
    EXPECT_EQ(content_of(folder.path() / "t.trc") == content_of(folder.path() / "again/t.trc"),
              true);
    EXPECT_TRUE(identical(back.time, file.markers.time));
    EXPECT_TRUE(identical(back.p_WM, file.markers.p_WM));
  }
}

struct StorageFacts {
  std::string path;
  int rows = 0, columns = 0;  // with time
  double from = 0.0, to = 0.0;
  std::optional<bool> in_degrees;
  std::string label;  // of the first column
  std::string warnings;
};

const std::string kAnalyze = kCore + "Applications/Analyze/tests/resources/";

const std::vector<StorageFacts> kStorageFacts = {
    {kAnalyze + "DoublePendulum3D_InitialStates.sto",
     1,
     5,
     0.0,
     0.0,
     {},
     "r1_z",
     "3: the header promises nColumns=4, the file has 5 columns; all of them were read\n"},
    {kAnalyze + "SinglePin_InitialStates.sto", 1, 3, 0.0, 0.0, {}, "r1_z", ""},
    {kAnalyze + "arm26_InverseKinematics.mot", 121, 12, 0.0, 1.0, {}, "r_shoulder_elev", ""},
    {kAnalyze + "std_SinglePin_JointReaction_ReactionLoads.sto", 301, 28, 0.0, 3.0, false,
     "pin1_on_rod1_in_rod1_fx",
     "3: the header promises nRows=302, the file has 301 rows; all of them were read\n"},
    {kAnalyze + "std_Thelen2003Muscle_arm26_StaticOptimization_force.sto", 121, 7,
     -2.0000000500175e-07, 0.999999399999985, false, "TRIlong", ""},
    {kAnalyze + "walk_subject01_Kinematics_q.sto", 2537, 11, 0.0, 2.499, true, "pelvis_tilt",
     "2548: 1 rows repeat the time of the row before; all are kept\n"},
    {kCore + "Applications/ID/tests/resources/subject01_walk1_grf.mot",
     9009,
     19,
     0.0,
     15.0133,
     {},
     "ground_force_vx",
     ""},
    {kCore + "Applications/ID/tests/resources/subject01_walk1_ik.mot", 211, 24, 0.5, 4.0, true,
     "pelvis_tilt", ""},
    {kCore + "Applications/IK/tests/resources/std_subject01_walk1_ik.mot",
     73,
     24,
     0.4,
     1.6,
     {},
     "pelvis_tilt",
     ""},
    {kCore + "Applications/IK/tests/resources/std_markers_coords_ik.sto",
     10,
     165,
     0.0,
     0.15,
     {},
     "R.ASIS_tx",
     "5: 9 columns repeat the label of an earlier one ('ground_force_vx', 'ground_force_vy', "
     "'ground_force_vz', ...); by name only the first of each is found\n"},
    {kCore + "OpenSim/Common/Test/sampleOutputsVec3.sto",
     471,
     7,
     0.0,
     0.5,
     {},
     "/model/ball|linear_velocity_x",
     ""},
    {kCore + "OpenSim/Common/Test/sampleOutputsSpatialVec.sto",
     471,
     13,
     0.0,
     0.5,
     {},
     "/model/ball|acceleration_rx",
     ""},
    {kCore + "OpenSim/Common/Test/testDiff.sto", 2, 3, 1.0, 2.0, {}, "v1", ""},
    {kCore + "OpenSim/Common/Test/std_walking2_grfs.sto", 101, 19, 0.0, 4.9955, {}, "f1_1", ""},
    {kCore + "OpenSim/Examples/Moco/example3DWalking/coordinates.sto", 1350, 32, 0.45, 1.799, false,
     "/jointset/ground_pelvis/pelvis_tilt/value",
     "3: the header promises nColumns=40, the file has 32 columns; all of them were read\n"},
    {kCore + "OpenSim/Tests/shared/gait10dof18musc_ik_CRLF_line_ending.mot", 15, 11, 0.0,
     0.23333333, true, "pelvis_tilt", ""},
    {kModels + "Gait2354_Simbody/reference/subject01_walk1_ik.mot", 73, 24, 0.4, 1.6, true,
     "pelvis_tilt", ""},
    {kArnold + "subject01/coordinates.sto", 223, 34, 3.38, 4.49, {}, "pelvis_tilt", ""},
    {kArnold + "subject01/id.sto", 223, 40, 3.38, 4.49, false, "pelvis_tilt_moment", ""},
    {kArnold + "subject02/trials/walk2/grf.mot", 235, 19, 3.08, 4.25, {}, "ground_force_r_vx", ""},
    {kBmc + "ExpData/grf_run.mot", 246, 19, 0.0, 0.81666667, {}, "R_ground_force_vx", ""},
    {kBmc + "ID/results/inverse_dynamics.sto", 109, 40, -4.1e-07, 0.71999887, false,
     "pelvis_tilt_moment", ""},
    {kBmc + "IK/results/ik_output_run.mot", 122, 40, 0.0, 0.80666667, true, "pelvis_tilt", ""},
    {kBmc + "SO/results/subject_so_StaticOptimization_force.sto", 109, 141, -4.1e-07, 0.71999887,
     false, "addbrev_r", ""},
};

TEST_F(RealRecordings, StorageFilesHoldWhatWasCounted) {
  for (const StorageFacts& facts : kStorageFacts) {
    SCOPED_TRACE(facts.path);
    const TimeTableFile file = read_storage(kData / facts.path);
    ASSERT_EQ(file.table.time.size(), facts.rows);
    EXPECT_EQ(file.table.labels.size() + 1, static_cast<std::size_t>(facts.columns));
    EXPECT_EQ(file.table.values.cols() + 1, facts.columns);
    EXPECT_NEAR(file.table.time[0], facts.from, 1e-15);
    EXPECT_NEAR(file.table.time[facts.rows - 1], facts.to, 1e-14);
    EXPECT_EQ(file.table.in_degrees, facts.in_degrees);
    EXPECT_EQ(file.table.labels[0], facts.label);
    EXPECT_EQ(to_text(file.warnings), facts.warnings);
    EXPECT_FALSE(file.table.values.array().isNaN().any());
  }
}

TEST_F(RealRecordings, EveryStorageFileRoundTrips) {
  const TemporaryFolder folder;
  const std::vector<fs::path> paths = files_with({".sto", ".mot"});
  EXPECT_GE(paths.size(), 80u);
  for (const fs::path& path : paths) {
    SCOPED_TRACE(path);
    const TimeTable table = read_storage(path).table;
    write_storage(folder.path() / "t.sto", table);
    const TimeTable back = read_storage(folder.path() / "t.sto").table;
    EXPECT_EQ(back.name, table.name);
    EXPECT_EQ(back.labels, table.labels);
    EXPECT_EQ(back.in_degrees, table.in_degrees);
    EXPECT_EQ(back.header, table.header);
    EXPECT_TRUE(identical(back.time, table.time));
    EXPECT_TRUE(identical(back.values, table.values));
  }
}

struct IkFacts {
  std::string path;
  std::size_t tasks = 0;
  double from = 0.0, to = 0.0, constraint_weight = 0.0, accuracy = 1e-5;
  std::string model, markers;  // relative to the setup's folder
};

TEST_F(RealRecordings, IkSetups) {
  const double inf = std::numeric_limits<double>::infinity();
  const std::string folder = kCore + "Applications/IK/tests/resources/";
  for (const IkFacts& facts : std::vector<IkFacts>{
           {folder + "subject01_Setup_InverseKinematics.xml", 31, 0.4, 1.6, 10.0, 1e-5,
            "subject01_simbody.osim", "subject01_synthetic_marker_data.trc"},
           {folder + "subject01_Setup_InverseKinematics_NoModel.xml", 31, 0.4, 1.6, 100.0, 1e-5, "",
            "subject01_synthetic_marker_data.trc"},
           {kModels + "Gait2354_Simbody/subject01_Setup_IK.xml", 35, 0.4, 1.6, 20.0, 1e-5,
            "subject01_simbody.osim", "subject01_walk1.trc"},
           {kModels + "Gait10dof18musc/IK/walk_Setup_IK.xml", 39, 0.0, 2.5, inf, 1e-5,
            "../subject01.osim", "../ExperimentalData/subject01_walk.trc"},
           {kBmc + "IK/IK_setup.xml", 64, 0.0, 0.813, inf, 1e-4,
            "../Scale/Rajagopal2015_scaled.osim", "../ExpData/motion_capture_run.trc"}}) {
    SCOPED_TRACE(facts.path);
    const IkSetup setup = read_ik_setup(kData / facts.path);
    EXPECT_EQ(setup.task_set.tasks.size(), facts.tasks);
    EXPECT_EQ(setup.from, facts.from);
    EXPECT_EQ(setup.to, facts.to);
    EXPECT_EQ(setup.constraint_weight, facts.constraint_weight);
    EXPECT_EQ(setup.accuracy, facts.accuracy);
    const fs::path base = fs::absolute(kData / facts.path).parent_path();
    EXPECT_EQ(setup.model_file,
              facts.model.empty() ? fs::path() : (base / facts.model).lexically_normal());
    EXPECT_EQ(setup.marker_file, (base / facts.markers).lexically_normal());
    EXPECT_TRUE(fs::exists(setup.marker_file));
    EXPECT_TRUE(setup.coordinate_file.empty());
  }
}

TEST_F(RealRecordings, IkTaskSets) {
  const fs::path folder = kData / kCore;
  EXPECT_EQ(
      read_ik_task_set(folder / "Applications/IK/tests/resources/gait2354_IK_Tasks_uniform.xml")
          .tasks.size(),
      31u);
  EXPECT_EQ(read_ik_task_set(folder / "OpenSim/Examples/Moco/example3DWalking/ik_tasks_walk.xml")
                .tasks.size(),
            34u);
  const IkTaskSet scale =
      read_ik_task_set(folder / "Applications/Scale/tests/resources/gait2354_Scale_Tasks.xml");
  EXPECT_GT(scale.tasks.size(), 40u);
}

struct IdFacts {
  std::string path;
  double from = 0.0, to = 0.0;
  std::string coordinates, output;  // relative to the setup's folder
  std::size_t excluded = 0;
};

TEST_F(RealRecordings, IdSetups) {
  for (const IdFacts& facts : std::vector<IdFacts>{
           {kCore + "Applications/ID/tests/resources/arm26_Setup_InverseDynamics.xml", 0.0, 1.0,
            "arm26_InverseKinematics.mot", "Results/arm26_InverseDynamics.sto", 1},
           {kAnalyze + "arm26_Setup_InverseDynamics.xml", 0.0, 1.0, "arm26_InverseKinematics.mot",
            "Results/arm26_InverseDynamics.sto", 0},
           {kCore + "Applications/ID/tests/resources/subject01_Setup_InverseDynamics.xml", 0.5, 1.6,
            "subject01_walk1_ik.mot", "Results/subject01_InverseDynamics.sto", 1},
           {kModels + "Gait2354_Simbody/subject01_Setup_InverseDynamics.xml", 0.4, 1.6,
            "subject01_walk1_ik.mot", "ResultsInverseDynamics/inverse_dynamics.sto", 1},
           {kModels + "Gait10dof18musc/ID/walk_Setup_ID.xml", 0.0, 2.5,
            "../IK/subject01_walk_IK.mot", "Results/subject01_walk_ID.sto", 1}}) {
    SCOPED_TRACE(facts.path);
    const IdSetup setup = read_id_setup(kData / facts.path);
    const fs::path base = fs::absolute(kData / facts.path).parent_path();
    EXPECT_EQ(setup.coordinates_file, (base / facts.coordinates).lexically_normal());
    EXPECT_EQ(setup.output_file, (base / facts.output).lexically_normal());
    EXPECT_EQ(setup.from, facts.from);
    EXPECT_EQ(setup.to, facts.to);
    EXPECT_EQ(setup.cutoff, 6.0);
    EXPECT_EQ(setup.forces_to_exclude.size(), facts.excluded);
  }
}

TEST_F(RealRecordings, SetupsWithDeadWindowsPaths) {
  const IdSetup id = read_id_setup(kData / kBmc / "ID/id_setup.xml");
  EXPECT_EQ(id.results_directory, "H:\\OpenSim\\Mod&Sim2018\\ID\\results");
  EXPECT_EQ(id.model_file, "");
  EXPECT_EQ(location_of(id, "results_directory").line, 5);
  const ExternalLoadsSetup loads = read_external_loads(kData / kBmc / "ID/grf_setup.xml");
  EXPECT_EQ(loads.data_file, "H:\\OpenSim\\Mod&Sim2018\\ExpData\\grf_run.mot");
  EXPECT_EQ(loads.kinematics_cutoff, 6.0);
  ExternalLoadsSetup bound = loads;
  const TimeTable grf = read_storage(kData / kBmc / "ExpData/grf_run.mot").table;
  bind_columns(bound, grf.labels, "grf_run.mot");
  EXPECT_EQ(bound.forces[1].torque_columns, loads.forces[1].torque_columns);
  EXPECT_EQ(read_external_loads(kData / kBmc / "SO/grf_setup.xml").forces.size(), 2u);
}

TEST_F(RealRecordings, ExternalLoadsNameColumnsOfTheirData) {
  for (const std::string& path :
       {kCore + "Applications/ID/tests/resources/subject01_walk1_grf.xml",
        kCore + "OpenSim/Examples/Moco/example3DWalking/grf_walk.xml",
        kModels + "Gait2354_Simbody/subject01_walk1_grf.xml",
        kModels + "Gait10dof18musc/ExperimentalData/subject01_walk_grf.xml"}) {
    SCOPED_TRACE(path);
    const ExternalLoadsSetup setup = read_external_loads(kData / path);
    const TimeTable data = read_storage(setup.data_file).table;
    ASSERT_EQ(setup.forces.size(), 2u);
    EXPECT_EQ(setup.forces[0].applied_to_body, "calcn_r");
    EXPECT_EQ(setup.forces[1].applied_to_body, "calcn_l");
    for (const ExternalForce& force : setup.forces) {
      EXPECT_TRUE(force.applies);
      for (const auto* columns :
           {&force.force_columns, &force.point_columns, &force.torque_columns}) {
        ASSERT_EQ(columns->size(), 3u);
        for (int axis = 0; axis < 3; ++axis) {
          const std::string& label = (*columns)[static_cast<std::size_t>(axis)];
          EXPECT_EQ(label.back(), "xyz"[axis]);
          EXPECT_GE(data.find_column(label), 0) << label;
        }
      }
    }
  }
  for (const std::string& path :
       {kAnalyze + "externalForces.xml",
        kCore + "OpenSim/Moco/Test/subject_walk_armless_external_loads.xml",
        kCore + "OpenSim/Moco/Test/walk_gait1018_subject01_grf.xml"}) {
    EXPECT_EQ(read_external_loads(kData / path).forces.size(), 2u) << path;
  }
}

}  // namespace
}  // namespace sinew
