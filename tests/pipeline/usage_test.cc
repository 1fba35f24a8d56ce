#include <gtest/gtest.h>

#include "tests/pipeline/command_line.h"
#include "tests/pipeline/small_trial.h"

namespace sinew {
namespace {

using Arguments = std::vector<std::string>;

class Usage : public ::testing::Test {
 protected:
  Usage() {
    SmallTrial::write(folder_);
    files_ = tree_of(folder_.path());
  }

  const std::filesystem::path& path() const { return folder_.path(); }

  // A run that is refused: exit 2, this message, nothing written.
  void expect_refused(const Arguments& arguments, const std::string& message) {
    const Outcome outcome = run_sinew(path(), arguments);
    std::string line;
    for (const std::string& argument : arguments) line += " " + argument;
    EXPECT_EQ(outcome.exit_code, 2) << line;
    EXPECT_EQ(error_line(outcome, path()), message) << line;
    EXPECT_EQ(outcome.out, "") << line;
    EXPECT_EQ(tree_of(path()), files_) << line;
  }

  static Arguments run(const Arguments& more = {}, const std::string& out = "results") {
    Arguments all = {"run", "--model", "model.osim", "--markers", "walk.trc", "--out", out};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }

  void write(const std::string& name, const std::string& content) {
    folder_.write(name, content);
    files_ = tree_of(path());
  }

  TemporaryFolder folder_;
  std::vector<std::string> files_;
};

TEST_F(Usage, NamesWhatIsNotASubcommandOrOption) {
  expect_refused({}, "A subcommand is required");
  expect_refused({"walk"}, "there is no subcommand 'walk'");
  expect_refused({"run", "--modle", "model.osim"},
                 "The following arguments were not expected: model.osim --modle");
  expect_refused({"run", "--model"}, "--model: 1 required TEXT missing");
  EXPECT_NE(run_sinew(path(), {"ik", "--nope"}).err.find("Run `sinew ik --help` for usage."),
            std::string::npos);
}

TEST_F(Usage, RefusesOptionsBeforeReadingAnything) {
  const std::string frequency = " is not a frequency in Hz above 0, or negative for no filter";
  const std::string threads = " is not a number of threads, 1 to 1024, or 0 for all there are";
  expect_refused(run({"--cutoff", "nan"}), "--cutoff: nan" + frequency);
  expect_refused(run({"--cutoff", "0"}), "--cutoff: 0" + frequency);
  expect_refused(run({"--cutoff", "six"}), "--cutoff: six" + frequency);
  expect_refused(run({"--threads", "-1"}), "--threads: -1" + threads);
  expect_refused(run({"--threads", "1e6"}), "--threads: 1e6" + threads);
  expect_refused(run({"--from", "nan"}), "--from: nan is not a time in seconds");
  expect_refused(run({"--to", "inf"}), "--to: inf is not a time in seconds");
  expect_refused(run({"--gradient-tolerance", "-1"}),
                 "--gradient-tolerance: -1 is not a number above 0");
  const Arguments trial = {"validate", "--model", "model.osim", "--markers", "walk.trc"};
  const auto validate = [&](const std::string& option, const std::string& value) {
    Arguments all = trial;
    all.insert(all.end(), {option, value});
    return all;
  };
  expect_refused(validate("--every", "0"), "--every: 0 is not a whole number, 1 or more");
  expect_refused(validate("--every", "2.5"), "--every: 2.5 is not a whole number, 1 or more");
  expect_refused(validate("--tolerance", "-1"), "--tolerance: -1 is not a number, 0 or more");
  expect_refused(validate("--accuracy", "0"), "--accuracy: 0 is not a number above 0");
}

TEST_F(Usage, ListsTheMethodsThereAre) {
  const Outcome outcome = run_sinew(path(), run({"--method", "newton"}));
  EXPECT_EQ(outcome.exit_code, 2);
  const std::string message = error_line(outcome, path());
  EXPECT_TRUE(message.starts_with("there is no method 'newton'; expected one of ")) << message;
  EXPECT_NE(message.find("gauss-newton"), std::string::npos) << message;
  EXPECT_EQ(tree_of(path()), files_);
}

TEST_F(Usage, SaysWhichFileIsMissing) {
  expect_refused({"run", "--model", "model.osim"}, "no markers: give --markers FILE.trc");
  expect_refused({"run", "--markers", "walk.trc"}, "no model: give --model FILE.osim");
  expect_refused({"ik", "--model", "model.osim", "--markers", "walk.trc"},
                 "no output file: give --out FILE, or name <output_motion_file> in the setup");
  expect_refused({"id", "--model", "model.osim"}, "no coordinates: give --coordinates FILE.mot");
  expect_refused({"id", "--model", "model.osim", "--coordinates", "q.mot"},
                 "no output file: give --out FILE.sto");
  expect_refused({"run", "--tasks", "tasks.xml"},
                 "no model and no markers for the other files: give --model FILE.osim and "
                 "--markers FILE.trc, or no file at all for the embedded walk");
  expect_refused(run({"--load-data", "grf.mot"}),
                 "--load-data needs --loads, which says what its columns act on: give --loads "
                 "FILE.xml");
  const std::string missing = ": no such file. Check the path and its spelling.";
  expect_refused({"run", "--model", "no.osim", "--markers", "walk.trc"}, "no.osim" + missing);
  expect_refused({"run", "--model", "model.osim", "--markers", "no.trc"}, "no.trc" + missing);
  expect_refused(run({"--tasks", "no.xml"}), "no.xml" + missing);
  expect_refused(run({"--loads", "no.xml"}), "no.xml" + missing);
  expect_refused(run({"--loads", "grf.xml", "--load-data", "no.mot"}), "no.mot" + missing);
  expect_refused({"ik", "--setup", "no.xml"}, "no.xml" + missing);
}

TEST_F(Usage, SaysWhereAFileIsOfAnotherKind) {
  std::filesystem::create_directory(path() / "folder");
  files_ = tree_of(path());
  expect_refused({"run", "--model", "folder", "--markers", "walk.trc"},
                 "folder: is a folder; expected a file. Name a file in it.");
  expect_refused({"run", "--model", "model.osim", "--markers", "model.osim"},
                 "model.osim:1: is no TRC file; expected 'PathFileType' at its beginning, found "
                 "<OpenSimDocument Version=\"40000\">. Is it the right file?");
  expect_refused(run({"--loads", "model.osim"}),
                 "model.osim:1: holds no ExternalLoads; expected an OpenSimDocument with "
                 "<ExternalLoads>, found OpenSimDocument with <Model>. Name the setup file of this "
                 "tool.");
}

TEST_F(Usage, RefusesAnOutputThatCannotBeWritten) {
  const std::string root = path().string();
  const auto file_for_folder = [&](const std::string& output, const std::string& file) {
    return output + ": cannot be written: " + file +
           " is a file, not a folder. Choose another path.";
  };
  const Arguments ik = {"ik", "--model", "model.osim", "--markers", "walk.trc", "--out"};
  const auto ik_to = [&](const std::string& out) {
    Arguments all = ik;
    all.push_back(out);
    return all;
  };
  expect_refused(run({}, "grf.mot"), file_for_folder("grf.mot/ik.mot", "grf.mot"));
  expect_refused(run({}, "grf.mot/x"), file_for_folder("grf.mot/x/ik.mot", "grf.mot"));
  expect_refused(run({}, ""), "--out is empty: give --out FOLDER");
  expect_refused(ik_to("."), ".: is a folder, where the output file should go. Name a file in it.");
  expect_refused(ik_to("grf.mot/q.mot"), file_for_folder("grf.mot/q.mot", "grf.mot"));
  // No one, root included, can make a file there.
  const Outcome outcome = run_sinew(path(), ik_to("/proc/sinew/q.mot"));
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(error_line(outcome, path()),
            "/proc/sinew/q.mot: cannot make the output's folder; found No such file or directory. "
            "Check the path, its permissions and the space left on the disk.");
  if (::geteuid() != 0) {
    std::filesystem::create_directory(path() / "locked");
    std::filesystem::permissions(path() / "locked", std::filesystem::perms::owner_read);
    expect_refused(ik_to("locked/q.mot"),
                   "locked/q.mot: cannot be written: folder locked: Permission denied. Choose "
                   "another path, or change the folder's permissions.");
    std::filesystem::permissions(path() / "locked", std::filesystem::perms::owner_all);
  }
}

TEST_F(Usage, NeverOverwritesAnInput) {
  const std::string remedy = ". Choose another output, so that the input is kept.";
  expect_refused({"ik", "--model", "model.osim", "--markers", "walk.trc", "--out", "./walk.trc"},
                 "./walk.trc: is both the output and an input (markers)" + remedy);
  write("ik.mot", content_of(path() / "walk.trc"));
  expect_refused({"run", "--model", "model.osim", "--markers", "ik.mot", "--out", "."},
                 "./ik.mot: is both the output and an input (markers)" + remedy);
  write("id.sto", content_of(path() / "grf.mot"));
  write("loads.xml", SmallTrial::loads_setup("id.sto"));
  expect_refused(run({"--loads", "loads.xml"}, "."),
                 "./id.sto: is both the output and an input (load_data)" + remedy);
  expect_refused({"id", "--model", "model.osim", "--coordinates", "ik.mot", "--out", "model.osim"},
                 "model.osim: is both the output and an input (model)" + remedy);
  expect_refused(
      {"validate", "--model", "model.osim", "--markers", "walk.trc", "--json", "model.osim"},
      "model.osim: is both the output and an input (model)" + remedy);
}

TEST_F(Usage, ChecksTheTraceAsAnOutput) {
  const Arguments ik = {"ik", "--model", "model.osim", "--markers", "walk.trc", "--out"};
  const auto ik_to = [&](const std::string& out, const std::string& trace) {
    Arguments all = ik;
    all.insert(all.end(), {out, "--trace", trace});
    return all;
  };
  expect_refused(ik_to("q.mot", "walk.trc"),
                 "walk.trc: is both the output and an input (markers). Choose another output, so "
                 "that the input is kept.");
  expect_refused(ik_to("q.mot", "./q.mot"),
                 "./q.mot: is two outputs at once. Choose another name for one of them.");
  expect_refused(run({"--trace", "results/summary.json"}),
                 "results/summary.json: is two outputs at once. Choose another name for one of "
                 "them.");
  const Outcome ignored = run_sinew(path(), {"validate", "--trace", "x.csv"});
  EXPECT_EQ(ignored.exit_code, 2);  // it writes no trace
}

TEST_F(Usage, RefusesTimesThatTheRecordingDoesNotHave) {
  const std::string record = "; walk.trc has 0 s to 1.5 s. Choose another with --from and --to.";
  expect_refused(run({"--from", "2", "--to", "1"}),
                 "walk.trc: the time range ends at 1 s, before it begins at 2 s. Exchange --from "
                 "and --to.");
  expect_refused(run({"--from", "7"}),
                 "walk.trc: no frame lies in the time range, from 7 s on" + record);
  expect_refused(run({"--to", "-1"}),
                 "walk.trc: no frame lies in the time range, up to -1 s" + record);
  expect_refused(run({"--from", "0.501", "--to", "0.504"}),
                 "walk.trc: no frame lies in the time range, 0.501 s to 0.504 s" + record);
}

TEST_F(Usage, RefusesBeforeSolvingWhatInverseDynamicsCannotDo) {
  expect_refused(run({"--cutoff", "60"}),
                 "walk.trc: cannot be differentiated: the low-pass cutoff of 60 Hz is not below "
                 "half the sampling rate of 100 Hz. Choose a cutoff below 50 Hz.");
  expect_refused(run({"--from", "0.5", "--to", "0.52"}),
                 "walk.trc: is too short to be differentiated; expected 6 frames or more, found 3. "
                 "Take a longer record, or a longer part of it.");
  write_storage(path() / "late.mot", SmallTrial::loads(0.5, 1.5));
  files_ = tree_of(path());
  expect_refused(run({"--loads", "grf.xml", "--load-data", "late.mot"}),
                 "late.mot: the external loads do not cover the motion; expected 0 to 1.5 s, found "
                 "0.5 to 1.5 s. Choose a time range within the loads.");
  TimeTable broken = SmallTrial::loads(0.0, 1.5);
  broken.values(40, 1) = std::numeric_limits<double>::quiet_NaN();
  write_storage(path() / "broken.mot", broken);
  files_ = tree_of(path());
  expect_refused(run({"--loads", "grf.xml", "--load-data", "broken.mot"}),
                 "broken.mot: column 'f_vy' of the external loads in row 41, at 0.2 s; expected a "
                 "number, found nan. Fill the gap, or write zeros if nothing touched the plate.");
}

TEST_F(Usage, SaysWhenNoMarkerMatches) {
  MarkerTrajectories others = SmallTrial::recording();
  for (std::string& name : others.names) name = "lab:" + name;
  write_trc(path() / "others.trc", others);
  files_ = tree_of(path());
  expect_refused({"run", "--model", "model.osim", "--markers", "others.trc"},
                 "others.trc: no marker is left to track; expected names that model 'swing' has "
                 "too (T1, T2, T3, L1, L,2, L3), found lab:T1, lab:T2, lab:T3, lab:L1, lab:L,2, "
                 "lab:L3. Rename markers, or add them to the model or to the tasks.");
}

std::string ik_setup(const std::string& fields) {
  return "<OpenSimDocument Version=\"40000\">\n<InverseKinematicsTool name=\"t\">\n"
         "<IKTaskSet><objects/></IKTaskSet>\n" +
         fields + "</InverseKinematicsTool>\n</OpenSimDocument>\n";
}

std::string id_setup(const std::string& fields) {
  return "<OpenSimDocument Version=\"40000\">\n<InverseDynamicsTool name=\"t\">\n" + fields +
         "</InverseDynamicsTool>\n</OpenSimDocument>\n";
}

TEST_F(Usage, PointsToTheSetupsLineAndTheOptionThatHelps) {
  write("ik.xml", ik_setup("<model_file>C:\\study\\model.osim</model_file>\n"
                           "<marker_file>Unassigned</marker_file>\n"
                           "<output_motion_file>C:\\study\\ik.mot</output_motion_file>\n"));
  expect_refused({"ik", "--setup", "ik.xml"},
                 "ik.xml:4: <model_file> names a file that does not exist; expected a path, "
                 "relative to the setup's folder, found C:\\study\\model.osim. Correct the setup, "
                 "or give --model FILE.");
  expect_refused({"ik", "--setup", "ik.xml", "--model", "model.osim"},
                 "ik.xml:5: <marker_file> names no file. Correct the setup, or give --markers "
                 "FILE.");
  expect_refused({"ik", "--setup", "ik.xml", "--model", "model.osim", "--markers", "walk.trc"},
                 "ik.xml:6: <output_motion_file> is a path of another system; expected a path, "
                 "relative to the setup's folder, found C:\\study\\ik.mot. Correct the setup, or "
                 "give --out FILE.");
  write("id.xml", id_setup("<model_file>model.osim</model_file>\n"
                           "<coordinates_file>gone.mot</coordinates_file>\n"
                           "<external_loads_file>gone.xml</external_loads_file>\n"
                           "<results_directory>C:\\study</results_directory>\n"));
  const std::string gone =
      "names a file that does not exist; expected a path, relative to the "
      "setup's folder, found gone.";
  expect_refused({"id", "--setup", "id.xml"},
                 "id.xml:4: <coordinates_file> " + gone +
                     "mot. Correct the setup, or give --coordinates FILE.");
  expect_refused(
      {"id", "--setup", "id.xml", "--coordinates", "q.mot"},
      "id.xml:5: <external_loads_file> " + gone + "xml. Correct the setup, or give --loads FILE.");
  expect_refused({"id", "--setup", "id.xml", "--coordinates", "q.mot", "--loads", "grf.xml"},
                 "id.xml:6: <results_directory> is a path of another system; expected a path, "
                 "relative to the setup's folder, found C:\\study/inverse_dynamics.sto. Correct "
                 "the setup, or give --out FILE.");
  write("far.xml", SmallTrial::loads_setup("H:\\grf.mot"));
  expect_refused(run({"--loads", "far.xml"}),
                 "far.xml:7: <datafile> names a file that does not exist; expected a path, "
                 "relative to the setup's folder, found H:\\grf.mot. Correct the setup, or give "
                 "--load-data FILE.");
}

TEST_F(Usage, PointsToASetupsTimeRange) {
  write("ik.xml", ik_setup("<model_file>model.osim</model_file>\n"
                           "<marker_file>walk.trc</marker_file>\n"
                           "<time_range>5 6</time_range>\n"
                           "<output_motion_file>out/q.mot</output_motion_file>\n"));
  expect_refused({"ik", "--setup", "ik.xml"},
                 "ik.xml:6: no frame lies in the time range, 5 s to 6 s; walk.trc has 0 s to 1.5 "
                 "s. Choose another with --from and --to.");
  const Outcome partly = run_sinew(path(), {"ik", "--setup", "ik.xml", "--from", "1"});
  EXPECT_EQ(partly.exit_code, 0) << partly.err;
  EXPECT_NE(partly.err.find(
                "warning: ik.xml:6: the time range, 1 s to 6 s, goes beyond the record; " +
                (path() / "walk.trc").string() + " has 0 s to 1.5 s, and only that is solved"),
            std::string::npos)
      << partly.err;
  EXPECT_EQ(read_storage(path() / "out/q.mot").table.time.size(), 51);
}

// Every option has a line of help; those that take a quantity say its unit.
TEST_F(Usage, HelpNamesOptionsAndUnits) {
  const std::vector<std::pair<std::string, std::vector<std::string>>> expected = {
      {"run",
       {"--model", "--markers", "--tasks", "--task-coordinates", "--from", "--to", "--method",
        "--gradient-tolerance", "--trace", "--threads", "--loads", "--load-data", "--cutoff",
        "--project-couplers", "--exact-custom-joints", "--out"}},
      {"ik",
       {"--setup", "--model", "--markers", "--tasks", "--task-coordinates", "--from", "--to",
        "--method", "--gradient-tolerance", "--trace", "--threads", "--out"}},
      {"id",
       {"--setup", "--model", "--coordinates", "--loads", "--load-data", "--cutoff", "--from",
        "--to", "--project-couplers", "--exact-custom-joints", "--threads", "--out"}},
      {"validate",
       {"--model", "--markers", "--tasks", "--task-coordinates", "--from", "--to", "--method",
        "--gradient-tolerance", "--every", "--accuracy", "--tolerance", "--json"}},
      {"compare", {"--model", "--from", "--to", "--worst", "--tolerance", "--percent", "--json"}},
      {"example", {"--out"}}};
  for (const auto& [command, options] : expected) {
    const Outcome help = run_sinew(path(), {command, "--help"});
    EXPECT_EQ(help.exit_code, 0);
    for (const std::string& option : options) {
      const std::size_t at = help.out.find("  " + option + " ");
      ASSERT_NE(at, std::string::npos) << command << " " << option << "\n" << help.out;
      const std::string line = help.out.substr(at, help.out.find('\n', at) - at);
      const std::string unit = option == "--from" || option == "--to" ? "[s]"
                               : option == "--cutoff"                 ? "[Hz]"
                                                                      : "";
      EXPECT_NE(line.find(unit), std::string::npos) << line;
    }
  }
}

}  // namespace
}  // namespace sinew
