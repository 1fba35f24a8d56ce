#include "pipeline/option_names.h"

#include <gtest/gtest.h>

#include "pipeline/command.h"
#include "tests/pipeline/command_line.h"

namespace sinew {
namespace {

TEST(OptionNames, ReplaceTheLibrarysOwn) {
  EXPECT_EQ(in_words_of_options("WholeBodyOptions::height is 9 m; it must be 1.2 to 2.3"),
            "--height is 9 m; it must be 1.2 to 2.3");
  EXPECT_EQ(in_words_of_options("MinimizerOptions.gradient_tolerance is -1; expected 0 or more"),
            "--gradient-tolerance is -1; expected 0 or more");
  // No option sets it: words are better than a name that nobody has seen.
  EXPECT_EQ(in_words_of_options("SideCheckOptions::least_share is 2; it must be at most 1"),
            "least share is 2; it must be at most 1");
  EXPECT_EQ(in_words_of_options("a.osim:3: <Model> of Options.xml is none"),
            "a.osim:3: <Model> of Options.xml is none");
  EXPECT_EQ(in_words_of_options(""), "");
}

// A name that is no option would send the user looking for it.
TEST(OptionNames, AreOptionsThatACommandHas) {
  const TemporaryFolder folder;
  std::string help;
  for (const char* command : {"run", "ik", "id", "scale", "example", "convert"}) {
    help += run_sinew(folder.path(), {command, "--help"}).out;
  }
  help += run_sinew(folder.path(), {"bench", "walk", "--help"}).out;
  for (const OptionName& name : option_names()) {
    EXPECT_TRUE(help.find(std::string(name.option) + " ") != help.npos ||
                help.find(std::string(name.option) + "=") != help.npos)
        << name.option;
  }
}

TEST(OptionNames, AreWhatTheCommandLineSays) {
  const TemporaryFolder folder;
  const Outcome outcome =
      run_sinew(folder.path(), {"model", "info", "whole-body", "--height", "9"});
  EXPECT_EQ(outcome.exit_code, 2);
  EXPECT_EQ(error_line(outcome, folder.path()), "--height is 9 m; it must be 1.2 to 2.3");
}

TEST(WarningLines, NameFilesWithoutFoldersAndARepeatedOneOnce) {
  const std::vector<Warning> warnings = {
      {{"/a/b/tasks.xml", 122}, "marker 'R.Heel' of a task is not in the recording"},
      {{"/a/b/tasks.xml", 128}, "marker 'R.Toe Tip' of a task is not in the recording"},
      {{"/a/b/walk.trc", 0}, "the range goes beyond the record; /a/b/walk.trc has 0 s to 1.5 s"},
      {{"/a/b/tasks.xml", 134}, "marker 'L.Heel' of a task is not in the recording"},
      {{"/a/b/walk.trc", 0},
       "LSHA: 3 trajectories have this label; they are called LSHA_2, LSHA_3"},
      {{"/a/b/walk.trc", 0},
       "RTHI: 2 trajectories have this label; they are called RTHI and RTHI_2"},
      {{"/a/c/walk.trc", 0},
       "RTHI: 2 trajectories have this label; they are called RTHI and RTHI_2"},
      {{"inverse dynamics", 0}, "no external loads are given"}};
  EXPECT_EQ(warning_lines(warnings),
            (std::vector<std::string>{
                "tasks.xml:122: marker 'R.Heel' of a task is not in the recording (and 2 more like "
                "it)",
                "walk.trc: the range goes beyond the record; walk.trc has 0 s to 1.5 s",
                "walk.trc: LSHA: 3 trajectories have this label; they are called LSHA_2, LSHA_3 "
                "(and 1 more like it)",
                "walk.trc: RTHI: 2 trajectories have this label; they are called RTHI and RTHI_2",
                "inverse dynamics: no external loads are given"}));
}

}  // namespace
}  // namespace sinew
