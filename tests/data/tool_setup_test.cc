#include "data/tool_setup.h"

#include <gtest/gtest.h>

#include <limits>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Strings = std::vector<std::string>;

std::string document(const std::string& content) {
  return "<?xml version=\"1.0\"?>\n<OpenSimDocument Version=\"40000\">\n" + content +
         "\n</OpenSimDocument>\n";
}

const std::string kTasks =
    "<objects>\n<IKMarkerTask name=\"R.ASIS\"><apply>false</apply><weight> 2.5 </weight>"
    "</IKMarkerTask>\n"
    "<IKCoordinateTask name=\"knee\"><weight>10</weight><value_type>manual_value</value_type>"
    "<value>0.5</value></IKCoordinateTask>\n"
    "<IKCoordinateTask name=\"hip\"><weight>1</weight><value_type>From_File</value_type>"
    "</IKCoordinateTask>\n<IKMarkerTask name=\"Top.Head\"/>\n</objects>";

TEST(ReadIkSetup, ReadsEveryField) {
  const TemporaryFolder folder;
  const auto path = folder.write(
      "ik.xml",
      document("<InverseKinematicsTool name=\"walk\">\n<model_file> ../m.osim </model_file>\n"
               "<constraint_weight>Inf</constraint_weight>\n<accuracy>1e-005</accuracy>\n"
               "<time_range> 0.4 1.6 </time_range>\n<marker_file>data\\walk.trc</marker_file>\n"
               "<coordinate_file>Unassigned</coordinate_file>\n"
               "<output_motion_file>C:\\out\\ik.mot</output_motion_file>\n"
               "<results_directory>./</results_directory>\n<IKTaskSet>" +
               kTasks + "</IKTaskSet>\n</InverseKinematicsTool>"));
  const IkSetup setup = read_ik_setup(path);
  EXPECT_EQ(setup.name, "walk");
  EXPECT_EQ(setup.model_file, folder.path().parent_path() / "m.osim");
  EXPECT_EQ(setup.marker_file, folder.path() / "data" / "walk.trc");
  EXPECT_EQ(setup.coordinate_file, "");
  EXPECT_EQ(setup.output_motion_file, "C:\\out\\ik.mot");
  EXPECT_EQ(setup.results_directory, folder.path());
  EXPECT_EQ(setup.from, 0.4);
  EXPECT_EQ(setup.to, 1.6);
  EXPECT_EQ(setup.constraint_weight, std::numeric_limits<double>::infinity());
  EXPECT_EQ(setup.accuracy, 1e-5);
  EXPECT_EQ(location_of(setup, "marker_file"), (SourceLocation{path.string(), 8}));
  EXPECT_EQ(location_of(setup, "report_errors"), (SourceLocation{path.string(), 0}));
}

TEST(ReadIkSetup, ReadsTasksWithOpenSimsDefaults) {
  const TemporaryFolder folder;
  const IkTaskSet set =
      read_ik_task_set(folder.write("t.xml", document("<IKTaskSet>" + kTasks + "</IKTaskSet>")));
  ASSERT_EQ(set.tasks.size(), 4u);
  EXPECT_EQ(set.tasks[0].name, "R.ASIS");
  EXPECT_EQ(set.tasks[0].kind, IkTask::Kind::kMarker);
  EXPECT_FALSE(set.tasks[0].apply);
  EXPECT_EQ(set.tasks[0].weight, 2.5);
  EXPECT_EQ(set.tasks[1].kind, IkTask::Kind::kCoordinate);
  EXPECT_EQ(set.tasks[1].value_type, IkTask::ValueType::kManual);
  EXPECT_EQ(set.tasks[1].value, 0.5);
  EXPECT_EQ(set.tasks[1].line, 5);
  EXPECT_EQ(set.tasks[2].value_type, IkTask::ValueType::kFromFile);
  EXPECT_EQ(set.tasks[3].weight, 0.0);
  EXPECT_EQ(to_text(set.warnings),
            "7: task 'Top.Head' has no weight; it gets OpenSim's default, 0\n");
}

TEST(ReadIkSetup, ReadsTasksFromAFileOfTheirOwn) {
  const TemporaryFolder folder;
  folder.write("tasks.xml", "<IKTaskSet name=\"t\">" + kTasks + "</IKTaskSet>");
  const auto path = folder.write(
      "ik.xml",
      "<InverseKinemtaticsTool><IKTaskSet file=\" tasks.xml \"/></InverseKinemtaticsTool>");
  const IkSetup setup = read_ik_setup(path);
  EXPECT_EQ(setup.task_set.tasks.size(), 4u);
  EXPECT_EQ(setup.task_set.path, (folder.path() / "tasks.xml").string());
  EXPECT_EQ(setup.constraint_weight, std::numeric_limits<double>::infinity());
  EXPECT_EQ(setup.from, std::nullopt);
  EXPECT_EQ(read_ik_task_set(path).tasks.size(), 4u);
}

TEST(ReadIkSetup, ReadsTheFirstTrialOfTheOldTool) {
  const TemporaryFolder folder;
  const IkSetup setup = read_ik_setup(folder.write(
      "ik.xml",
      "<IKTool name=\"old\"><model_file>m.osim</model_file><IKTaskSet>" + kTasks +
          "</IKTaskSet><IKTrialSet><objects>\n<IKTrial><marker_file>a.trc</marker_file>"
          "<time_range>0 1</time_range></IKTrial>\n<IKTrial/></objects></IKTrialSet></IKTool>"));
  EXPECT_EQ(setup.marker_file, folder.path() / "a.trc");
  EXPECT_EQ(setup.to, 1.0);
  EXPECT_EQ(setup.constraint_weight, 20.0);
  EXPECT_EQ(to_text(setup.warnings), "8: only the first trial of the IKTrialSet is read\n");
}

TEST(ReadIdSetup, ReadsEveryField) {
  const TemporaryFolder folder;
  const IdSetup setup = read_id_setup(folder.write(
      "id.xml",
      document(
          "<InverseDynamicsTool name=\"walk\"><model_file>m.osim</model_file>"
          "<results_directory>Results</results_directory><time_range>-Inf 1.6</time_range>"
          "<forces_to_exclude> Muscles reserve </forces_to_exclude>"
          "<external_loads_file>grf.xml</external_loads_file>"
          "<coordinates_file>../ik.mot</coordinates_file>"
          "<lowpass_cutoff_frequency_for_coordinates>6</lowpass_cutoff_frequency_for_coordinates>"
          "<output_gen_force_file>out</output_gen_force_file></InverseDynamicsTool>")));
  EXPECT_EQ(setup.model_file, folder.path() / "m.osim");
  EXPECT_EQ(setup.external_loads_file, folder.path() / "grf.xml");
  EXPECT_EQ(setup.coordinates_file, folder.path().parent_path() / "ik.mot");
  EXPECT_EQ(setup.results_directory, folder.path() / "Results");
  EXPECT_EQ(setup.output_file, folder.path() / "Results" / "out.sto");
  EXPECT_EQ(setup.from, std::nullopt);
  EXPECT_EQ(setup.to, 1.6);
  EXPECT_EQ(setup.cutoff, 6.0);
  EXPECT_EQ(setup.forces_to_exclude, (Strings{"Muscles", "reserve"}));
}

TEST(ReadIdSetup, HasOpenSimsDefaults) {
  const TemporaryFolder folder;
  const IdSetup setup = read_id_setup(
      folder.write("id.xml",
                   "<InverseDynamicsTool>\n<coordinates_in_degrees>true</coordinates_in_degrees>"
                   "</InverseDynamicsTool>"));
  EXPECT_EQ(setup.results_directory, folder.path());
  EXPECT_EQ(setup.output_file, folder.path() / "inverse_dynamics.sto");
  EXPECT_LT(setup.cutoff, 0.0);
  EXPECT_EQ(to_text(setup.warnings),
            "2: <coordinates_in_degrees> is not read, as OpenSim no longer reads it; the header of "
            "the coordinates_file decides\n");
}

std::string external_force(const std::string& fields) {
  return document("<ExternalLoads><objects>\n<ExternalForce name=\"right\">" + fields +
                  "</ExternalForce></objects><datafile>grf.mot</datafile></ExternalLoads>");
}

TEST(ReadExternalLoads, FindsTheColumnsOfTheDataFile) {
  const TemporaryFolder folder;
  folder.write("grf.mot",
               "grf\nendheader\ntime\tf_vx\tf_vy\tf_vz\tf_pz\tf_px\tf_py\tl_f_vx\tt_x\tt_y\tt_z\n");
  const auto path = folder.write(
      "loads.xml",
      external_force(
          "<applied_to_body>/bodyset/calcn_r</applied_to_body>"
          "<force_expressed_in_body>/ground</force_expressed_in_body>"
          "<force_identifier> f_v </force_identifier>"
          "<point_identifier>f_p</point_identifier><torque_identifier>t</torque_identifier>"
          "<data_source_name>Unassigned</data_source_name>"));
  const ExternalLoadsSetup setup = read_external_loads(path);
  ASSERT_EQ(setup.forces.size(), 1u);
  const ExternalForce& force = setup.forces[0];
  EXPECT_TRUE(force.applies);
  EXPECT_EQ(force.name, "right");
  EXPECT_EQ(force.applied_to_body, "calcn_r");
  EXPECT_EQ(force.force_expressed_in_body, "ground");
  EXPECT_EQ(force.force_identifier, "f_v");
  EXPECT_EQ(force.force_columns, (Strings{"f_vx", "f_vy", "f_vz"}));
  EXPECT_EQ(force.point_columns, (Strings{"f_px", "f_py", "f_pz"}));
  // `t` begins `time` too, but that is no column of data.
  EXPECT_EQ(force.torque_columns, (Strings{"t_x", "t_y", "t_z"}));
  EXPECT_EQ(force.line, 4);
  EXPECT_EQ(setup.data_file, folder.path() / "grf.mot");
  EXPECT_TRUE(setup.warnings.empty());
}

TEST(ReadExternalLoads, StaysReadableWithoutTheDataFile) {
  const TemporaryFolder folder;
  ExternalLoadsSetup setup = read_external_loads(folder.write(
      "loads.xml",
      "<ExternalLoads><objects><ExternalForce name=\"r\"><isDisabled>false</isDisabled>"
      "<applied_to_body>b</applied_to_body><force_identifier>f_v</force_identifier>"
      "</ExternalForce></objects>\n<datafile>H:\\OpenSim\\grf.mot</datafile>"
      "</ExternalLoads>"));
  EXPECT_EQ(setup.data_file, "H:\\OpenSim\\grf.mot");
  EXPECT_EQ(location_of(setup, "datafile").line, 2);
  EXPECT_EQ(setup.forces[0].force_columns, (Strings{"f_vx", "f_vy", "f_vz"}));
  EXPECT_TRUE(setup.forces[0].torque_columns.empty());
  bind_columns(setup, {"f_v1", "f_v2", "f_v3", "other"}, "other.mot");
  EXPECT_EQ(setup.forces[0].force_columns, (Strings{"f_v1", "f_v2", "f_v3"}));
}

TEST(BindColumns, PrefersAxesWhereMoreLabelsBeginAlike) {
  ExternalLoadsSetup setup;
  setup.forces.resize(1);
  setup.forces[0].force_identifier = "f";
  bind_columns(setup, {"f_px", "f_py", "f_pz", "f_x", "f_y", "f_z"}, "grf.mot");
  EXPECT_EQ(setup.forces[0].force_columns, (Strings{"f_x", "f_y", "f_z"}));
  setup.forces[0].applies = false;
  setup.forces[0].force_identifier = "nothing";
  bind_columns(setup, {"f_x"}, "grf.mot");
  EXPECT_TRUE(setup.forces[0].force_columns.empty());
}

TEST(ReadExternalLoads, TakesDisabledForcesThatLackEverything) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& fields) {
    return read_external_loads(folder.write("loads.xml", external_force(fields))).forces[0].applies;
  };
  EXPECT_FALSE(read("<isDisabled>true</isDisabled>"));
  EXPECT_FALSE(read("<appliesForce>false</appliesForce>"));
}

}  // namespace
}  // namespace sinew
