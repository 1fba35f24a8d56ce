#include "data/scale_setup.h"

#include <gtest/gtest.h>

#include "tests/data/test_files.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;
using Eigen::Vector3d;

std::string document(const std::string& content) {
  return "<OpenSimDocument Version=\"30000\">\n" + content + "\n</OpenSimDocument>\n";
}

const std::string kMeasurements =
    "<objects>\n<Measurement name=\"thigh\"><apply> true </apply><MarkerPairSet><objects>"
    "<MarkerPair><markers> HIP KNEE </markers></MarkerPair></objects></MarkerPairSet>\n"
    "<BodyScaleSet><objects><BodyScale name=\"femur_r\"><axes> X Y Z</axes></BodyScale>\n"
    "<BodyScale "
    "name=\"femur_l\"><axes>y</axes></BodyScale></objects></BodyScaleSet></Measurement>\n"
    "<Measurement name=\"off\"><apply>false</apply></Measurement>\n</objects>";

const std::string kScales =
    "<objects><Scale><scales> 1.1 1.2 1.3</scales><segment> tibia_r </segment></Scale>"
    "<Scale><segment>pelvis</segment><apply>false</apply></Scale></objects>";

std::string setup_text(const std::string& order = "measurements manualScale",
                       const std::string& measurements = kMeasurements,
                       const std::string& scales = kScales) {
  return document(
      "<ScaleTool name=\"subject\">\n<mass> 72.6 </mass>\n<GenericModelMaker>\n"
      "<model_file> ../generic.osim </model_file>\n<marker_set_file>Unassigned</marker_set_file>\n"
      "</GenericModelMaker>\n<ModelScaler>\n<apply>true</apply>\n<scaling_order>" +
      order + "</scaling_order>\n<MeasurementSet>" + measurements +
      "</MeasurementSet>\n<ScaleSet>" + scales +
      "</ScaleSet>\n<marker_file>data\\static.trc</marker_file>\n<time_range> 1 2 </time_range>\n"
      "<preserve_mass_distribution>true</preserve_mass_distribution>\n"
      "<output_model_file>C:\\out\\scaled.osim</output_model_file>\n"
      "<output_scale_file>applied.xml</output_scale_file>\n</ModelScaler>\n<MarkerPlacer>\n"
      "<IKTaskSet><objects><IKMarkerTask name=\"HIP\"><weight>10</weight></IKMarkerTask></objects>"
      "</IKTaskSet>\n<marker_file>data/static.trc</marker_file>\n<time_range>0 inf</time_range>\n"
      "<output_motion_file>static.mot</output_motion_file>\n"
      "<max_marker_movement>-1</max_marker_movement>\n</MarkerPlacer>\n</ScaleTool>");
}

TEST(ReadScaleSetup, ReadsEveryField) {
  const TemporaryFolder folder;
  const ScaleSetup setup = read_scale_setup(folder.write("scale.xml", setup_text()));
  EXPECT_EQ(setup.name, "subject");
  EXPECT_EQ(setup.mass, 72.6);
  EXPECT_EQ(setup.generic.model_file, folder.path().parent_path() / "generic.osim");
  EXPECT_EQ(setup.generic.marker_set_file, "");
  const ModelScalerSetup& scaler = setup.scaler;
  EXPECT_TRUE(scaler.apply);
  EXPECT_EQ(scaler.order,
            (std::vector<ModelScalerSetup::Step>{ModelScalerSetup::Step::kMeasurements,
                                                 ModelScalerSetup::Step::kManual}));
  ASSERT_EQ(scaler.measurements.size(), 2u);
  EXPECT_EQ(scaler.measurements[0].name, "thigh");
  EXPECT_EQ(scaler.measurements[0].pairs[0].first, "HIP");
  EXPECT_EQ(scaler.measurements[0].pairs[0].second, "KNEE");
  EXPECT_EQ(scaler.measurements[0].bodies[0].body, "femur_r");
  EXPECT_EQ(scaler.measurements[0].bodies[0].axes, (std::array<bool, 3>{true, true, true}));
  EXPECT_EQ(scaler.measurements[0].bodies[1].axes, (std::array<bool, 3>{false, true, false}));
  EXPECT_EQ(scaler.measurements[0].line, 12);
  EXPECT_FALSE(scaler.measurements[1].apply);
  ASSERT_EQ(scaler.manual.scales.size(), 2u);
  EXPECT_EQ(scaler.manual.scales[0].body, "tibia_r");
  EXPECT_EQ(scaler.manual.scales[0].factors, Vector3d(1.1, 1.2, 1.3));
  EXPECT_FALSE(scaler.manual.scales[1].apply);
  EXPECT_EQ(scaler.marker_file, folder.path() / "data" / "static.trc");
  EXPECT_EQ(scaler.from, 1.0);
  EXPECT_EQ(scaler.to, 2.0);
  EXPECT_TRUE(scaler.preserve_mass_distribution);
  EXPECT_EQ(scaler.output_model_file, "C:\\out\\scaled.osim");
  EXPECT_EQ(scaler.output_scale_file, folder.path() / "applied.xml");
  EXPECT_TRUE(setup.placer.apply);
  ASSERT_EQ(setup.placer.task_set.tasks.size(), 1u);
  EXPECT_EQ(setup.placer.task_set.tasks[0].weight, 10.0);
  EXPECT_EQ(setup.placer.from, 0.0);
  EXPECT_EQ(setup.placer.to, std::nullopt);
  EXPECT_EQ(setup.placer.output_motion_file, folder.path() / "static.mot");
  EXPECT_EQ(setup.placer.max_marker_movement, std::nullopt);
}

TEST(ReadScaleSetup, TakesSetsFromFilesOfTheirOwn) {
  const TemporaryFolder folder;
  folder.write("m.xml", document("<MeasurementSet>" + kMeasurements + "</MeasurementSet>"));
  folder.write("s.xml", document("<ScaleSet>" + kScales + "</ScaleSet>"));
  const ScaleSetup setup = read_scale_setup(folder.write(
      "scale.xml", document("<ScaleTool><ModelScaler><MeasurementSet file=\"m.xml\"/><ScaleSet "
                            "file=\"s.xml\"/></ModelScaler></ScaleTool>")));
  ASSERT_EQ(setup.scaler.measurements.size(), 2u);
  EXPECT_EQ(setup.scaler.measurement_path, (folder.path() / "m.xml").string());
  EXPECT_EQ(setup.scaler.manual.path, (folder.path() / "s.xml").string());
  EXPECT_FALSE(setup.placer.apply);
  EXPECT_EQ(setup.mass, std::nullopt);
}

TEST(ReadScaleSetup, RefusesWhatIsUnusable) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    return error_of(folder.path(), [&] { read_scale_setup(folder.write("s.xml", text)); });
  };
  EXPECT_EQ(refusal(document("<InverseKinematicsTool/>")),
            "s.xml:1: holds no ScaleTool; expected an OpenSimDocument with <ScaleTool>, found "
            "OpenSimDocument with <InverseKinematicsTool>. Name the setup file of this tool.");
  EXPECT_EQ(refusal(setup_text("measurement")),
            "s.xml:10: <scaling_order> names an unknown step; expected measurements, manualScale "
            "or both, found measurement. Correct the word.");
  EXPECT_EQ(
      refusal(setup_text("measurements",
                         "<objects><Measurement name=\"a\"><MarkerPairSet><objects>\n<MarkerPair>"
                         "<markers>HIP</markers></MarkerPair></objects></MarkerPairSet>"
                         "</Measurement></objects>")),
      "s.xml:12: a marker pair of measurement 'a' is no pair; expected the names of two markers in "
      "<markers>, found HIP. Name two different markers.");
  EXPECT_EQ(
      refusal(setup_text("measurements",
                         "<objects><Measurement name=\"a\"><BodyScaleSet><objects>\n<BodyScale "
                         "name=\"b\"><axes>X W</axes></BodyScale></objects></BodyScaleSet>"
                         "</Measurement></objects>")),
      "s.xml:12: <axes> of body 'b' names no axis; expected X, Y or Z, separated by blanks, found "
      "W. Correct the axis.");
  EXPECT_EQ(refusal(setup_text("manualScale", "",
                               "<objects>\n<Scale><scales>1 0 1</scales><segment>b</segment>"
                               "</Scale></objects>")),
            "s.xml:13: the factors of 'b' are no scale factors; expected three numbers above 0, "
            "found 1 0 1. Correct the factors.");
  EXPECT_EQ(refusal(setup_text("manualScale", "",
                               "<objects>\n<Scale><scales>1 1 1</scales></Scale></objects>")),
            "s.xml:13: a <Scale> names no body; expected the name of a body in <segment>. Name the "
            "body.");
  EXPECT_EQ(refusal(document("<ScaleTool><mass>inf</mass></ScaleTool>")),
            "s.xml:2: <mass> is no mass; expected kilograms, or -1 for an unknown mass, found inf. "
            "Correct the value.");
  EXPECT_EQ(refusal(document("<ScaleTool><ModelScaler><ScaleSet file=\"no.xml\"/></ModelScaler>"
                             "</ScaleTool>")),
            "s.xml:2: the file of the <ScaleSet> does not exist; expected a path, relative to the "
            "setup's folder, found no.xml. Correct the attribute 'file'.");
}

TEST(ScaleSet, IsReadAsItWasWritten) {
  const TemporaryFolder folder;
  ScaleSet set;
  set.scales = {{"pelvis", {1.0245770378331935, 1.0, 0.1}, true, 0},
                {"femur_r", {1, 2, 3}, false, 0}};
  ScaleSet read = read_scale_set(folder.write("s.xml", write_scale_set(set)));
  for (ManualScale& scale : read.scales) scale.line = 0;
  EXPECT_EQ(read.scales, set.scales);
}

TEST(ReadScaleTable, TakesOneFactorOrThree) {
  const TemporaryFolder folder;
  const ScaleSet set = read_scale_table(
      folder.write("f.csv", "body,x,y,z\n# comment\npelvis, 1.1, 1.2, 1.3\r\n\nfemur_r,0.9\n"));
  ASSERT_EQ(set.scales.size(), 2u);
  EXPECT_EQ(set.scales[0], (ManualScale{"pelvis", {1.1, 1.2, 1.3}, true, 3}));
  EXPECT_EQ(set.scales[1], (ManualScale{"femur_r", {0.9, 0.9, 0.9}, true, 5}));
}

TEST(ReadScaleTable, RefusesWhatIsUnusable) {
  const TemporaryFolder folder;
  const auto refusal = [&](const std::string& text) {
    return error_of(folder.path(), [&] { read_scale_table(folder.write("f.csv", text)); });
  };
  EXPECT_EQ(refusal("body,factor\n"),
            "f.csv: holds no scale factors; expected rows such as "
            "femur_r,1.05");
  EXPECT_EQ(refusal("pelvis,1.0\nfemur_r,1.0,1.1\n"),
            "f.csv:2: the row has the wrong number of cells; expected a body and 1 or 3 factors, "
            "separated by commas, found 3. Correct the row.");
  EXPECT_EQ(refusal("pelvis,1.0\nfemur_r,x\n"),
            "f.csv:2: a factor of body 'femur_r' is no scale factor; expected a number above 0, "
            "found x. Correct the factor.");
  EXPECT_EQ(refusal("pelvis,1.0\npelvis,1.1\n"),
            "f.csv:2: body 'pelvis' has a second row; expected one row a body. Remove one of "
            "them.");
}

// The setups of every version that OpenSim's own distribution and a laboratory have.
TEST(ReadScaleSetup, ReadsPublishedSetups) {
  const fs::path shared = "../shared/data";
  if (!fs::exists(shared)) GTEST_SKIP() << "needs the published setups in ../shared/data";
  const auto core = read_scale_setup(
      shared / "opensim-core/Applications/Scale/tests/resources/subject01_Setup_Scale_GUI.xml");
  EXPECT_EQ(core.generic.model_file, "");
  EXPECT_EQ(core.scaler.measurements.size(), 5u);
  EXPECT_EQ(core.scaler.manual.scales.size(), 4u);
  const auto run = read_scale_setup(shared / "BMC/data/opensim/Mod&Sim2018/Scale/scale_setup.xml");
  EXPECT_EQ(run.mass, 70.0);
  EXPECT_EQ(run.scaler.measurements.size(), 9u);
  EXPECT_EQ(run.scaler.measurements[0].pairs.size(), 6u);
  EXPECT_EQ(run.placer.task_set.tasks.size(), 42u);
  EXPECT_EQ(run.scaler.output_model_file, "");
  EXPECT_EQ(run.placer.output_model_file.filename(), "subject_scaled_run.osim");
}

}  // namespace
}  // namespace sinew
