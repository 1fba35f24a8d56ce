#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "model/osim_file.h"
#include "model/osim_writer.h"
#include "tests/model/leg_model.h"
#include "tests/model/same_model.h"
#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

using Arguments = std::vector<std::string>;

class ModelCommand : public ::testing::Test {
 protected:
  ModelCommand() : model_(leg_model()) { folder_.write("legs.osim", write_osim(model_)); }

  Outcome run(Arguments arguments) const {
    arguments.insert(arguments.begin(), "model");
    return run_sinew(folder_.path(), arguments);
  }

  void expect_refused(const Arguments& arguments, const std::string& message) const {
    const auto files = tree_of(folder_.path());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 2) << message;
    EXPECT_EQ(error_line(outcome, folder_.path()), message);
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(tree_of(folder_.path()), files);
  }

  TemporaryFolder folder_;
  MusculoskeletalModel model_;
};

TEST_F(ModelCommand, TellsCountsAndTheTree) {
  const Outcome outcome = run({"info", "legs.osim"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "legs: 9 degrees of freedom (0 of them locked, 0 coordinates coupled), 7 bodies, 0 "
            "virtual links, 8 wires, 4 markers, 28.000 kg\n"
            "paths: 8 muscles, 0 tendons, 0 ligaments, 0 actuators\n"
            "\n"
            "body                                   mass kg  paths joint     coordinates\n"
            "pelvis                                 10.0000      0 planar    tilt, tx, ty\n"
            "  femur_r                               5.0000      1 pin       hip_r\n"
            "    tibia_r                             3.0000      2 pin       knee_r\n"
            "      calcn_r                           1.0000      3 pin       ankle_r\n"
            "  femur_l                               5.0000      1 pin       hip_l\n"
            "    tibia_l                             3.0000      2 pin       knee_l\n"
            "      calcn_l                           1.0000      3 pin       ankle_l\n");
}

TEST_F(ModelCommand, TellsCountsAndMomentArmsAsJson) {
  const Outcome outcome =
      run({"info", "legs.osim", "--json", "--moment-arms", "hip_r", "--points", "3"});
  ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["dof"], 9);
  EXPECT_EQ(json["bodies"], 7);
  EXPECT_EQ(json["virtual_links"], 0);
  EXPECT_EQ(json["wires"], 8);
  EXPECT_EQ(json["markers"], 4);
  EXPECT_DOUBLE_EQ(json["mass"].get<double>(), 28.0);
  ASSERT_EQ(json["tree"].size(), 7u);
  EXPECT_EQ(json["tree"][3]["body"], "calcn_r");
  EXPECT_EQ(json["tree"][3]["parent"], "tibia_r");
  EXPECT_EQ(json["tree"][3]["crossing_paths"], 3);
  EXPECT_EQ(json["tree"][3]["coordinates"][0]["name"], "ankle_r");
  const auto& arms = json["moment_arms"];
  EXPECT_EQ(arms["coordinate"], "hip_r");
  EXPECT_EQ(arms["values"], (std::vector<double>{-1.0, 0.0, 1.0}));
  ASSERT_EQ(arms["paths"].size(), 1u);
  EXPECT_EQ(arms["paths"][0]["path"], "flexor_r");
  // a·b / √(a² + b²) of the right triangle at zero, see the tests of moment_arm_table().
  EXPECT_NEAR(arms["paths"][0]["arms"][1].get<double>(), 0.02 / std::hypot(0.1, 0.2), 1e-15);
}

TEST_F(ModelCommand, TabulatesMomentArms) {
  const Outcome outcome = run({"info", "legs.osim", "--moment-arms", "hip_r", "--points", "3"});
  EXPECT_NE(outcome.out.find("moment arms about hip_r [mm], 1 of 8 paths\n"
                             "deg                             -57.3      0.0     57.3\n"
                             "flexor_r                        "),
            std::string::npos)
      << outcome.out;
}

TEST_F(ModelCommand, SizesTheBuiltInBodies) {
  const auto mass = [&](const Arguments& more) {
    Arguments arguments = {"info", "whole-body", "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out)["mass"].get<double>();
  };
  EXPECT_NEAR(mass({}), 75.0, 1e-9);
  EXPECT_NEAR(mass({"--mass", "60", "--height", "1.65", "--sex", "female"}), 60.0, 1e-9);
}

TEST_F(ModelCommand, ChecksAndFailsOnErrors) {
  const Outcome good = run({"check", "legs.osim"});
  EXPECT_EQ(good.exit_code, 0);
  EXPECT_EQ(good.out, "0 errors, 0 warnings, 0 notes\n");

  MusculoskeletalModel bad = model_;
  bad.coordinates[0].default_value = 1.5;
  bad.coordinates[0].clamped = true;
  bad.bodies[2].mass = 6.0;
  folder_.write("bad.osim", write_osim(bad));
  const Outcome text = run({"check", "bad.osim"});
  EXPECT_EQ(text.exit_code, 1);
  EXPECT_TRUE(text.out.starts_with(
      "error: coordinate: tilt: its default 1.5 is outside its range -1 to 1, which it is clamped "
      "to (bad.osim:"))
      << text.out;
  EXPECT_TRUE(text.out.ends_with("1 errors, 1 warnings, 0 notes\n")) << text.out;

  const Outcome outcome = run({"check", "bad.osim", "--json"});
  EXPECT_EQ(outcome.exit_code, 1);
  const auto json = nlohmann::json::parse(outcome.out);
  EXPECT_EQ(json["errors"], 1);
  EXPECT_EQ(json["warnings"], 1);
  EXPECT_EQ(json["findings"][0]["severity"], "error");
  EXPECT_EQ(json["findings"][0]["element"], "tilt");
  EXPECT_GT(json["findings"][0]["line"], 0);
  EXPECT_EQ(run({"check", "bad.osim", "--relative-tolerance", "0.2", "--json"}).out.find("femur_r"),
            std::string::npos);
}

TEST_F(ModelCommand, ExportsWhatItReadsBack) {
  const Outcome outcome = run({"export", "legs.osim", "--out", "again.osim"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out, "again.osim\n");
  expect_same(model_, read_osim(folder_.path() / "again.osim"));
  EXPECT_EQ(run({"export", "whole-body", "--out", "body.osim"}).exit_code, 0);
  EXPECT_NEAR(read_osim(folder_.path() / "body.osim").total_mass(), 75.0, 1e-9);
}

TEST_F(ModelCommand, Furcates) {
  const Outcome outcome = run({"furcate", "legs.osim", "--out", "forked.osim"});
  EXPECT_EQ(outcome.exit_code, 0) << outcome.err;
  EXPECT_EQ(outcome.out,
            "virtual link                 bone       tendon mm spread mm  muscles\n"
            "furcation_calcn_r_1          calcn_r        105.6       4.0  gas_med_r, gas_lat_r, "
            "soleus_r\n"
            "furcation_calcn_l_1          calcn_l        105.6       4.0  gas_med_l, gas_lat_l, "
            "soleus_l\n"
            "forked.osim\n");
  EXPECT_EQ(read_osim(folder_.path() / "forked.osim").virtual_link_count(), 2);

  const Outcome named = run({"furcate", "legs.osim", "--out", "named.osim", "--muscles",
                             "gas_med_r,soleus_r:achilles_r", "--muscles", "gas_med_l,gas_lat_l"});
  EXPECT_EQ(named.exit_code, 0) << named.err;
  const MusculoskeletalModel model = read_osim(folder_.path() / "named.osim");
  EXPECT_GT(model.find_body("achilles_r"), 0);
  EXPECT_GT(model.find_body("furcation_calcn_l_1"), 0);

  const Outcome none = run({"furcate", "legs.osim", "--out", "none.osim", "--distance", "0.0001"});
  EXPECT_EQ(none.exit_code, 1);
  EXPECT_EQ(error_line(none, folder_.path()),
            "no two muscles end within 0.0001 m of each other on one bone; nothing was written. "
            "Allow a larger --distance.");
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "none.osim"));
}

TEST_F(ModelCommand, RefusesWhatItCannotUse) {
  expect_refused({}, "A subcommand is required");
  expect_refused({"info"}, "MODEL is required");
  expect_refused({"info", "no.osim"}, "no.osim: no such file. Check the path and its spelling.");
  expect_refused({"info", "legs.osim", "--height", "1.8"},
                 "--height, --mass and --sex are for the built-in bodies; 'legs.osim' is a file");
  expect_refused({"info", "whole-body", "--height", "0"}, "--height: 0 is not a number above 0");
  expect_refused({"info", "legs.osim", "--moment-arms", "elbow"},
                 "legs: has no coordinate 'elbow'; expected the name of one of its coordinates. "
                 "See `sinew model info`.");
  expect_refused({"export", "legs.osim"}, "--out is required");
  expect_refused({"furcate", "legs.osim", "--out", "x.osim", "--muscles", "soleus_r"},
                 "'soleus_r' is no furcation; expected two or more different muscles");
  const Outcome onto_itself = run({"export", "legs.osim", "--out", "legs.osim"});
  EXPECT_EQ(onto_itself.exit_code, 2);
  expect_same(model_, read_osim(folder_.path() / "legs.osim"));
}

}  // namespace
}  // namespace sinew
