#include "data/marker_matching.h"

#include <gtest/gtest.h>

#include "data/marker_synonyms.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

using Names = std::vector<std::string>;

MarkerMatching match(const Names& recorded, const Names& model, MatchingOptions options = {}) {
  return match_markers(recorded, model, options, "walk.c3d");
}

// The model's name of each recorded marker, `-` where there is none.
Names named(const MarkerMatching& matching, const Names& recorded, const Names& model) {
  Names names(recorded.size(), "-");
  for (const MarkerMatch& m : matching.matches) {
    names[static_cast<std::size_t>(m.recorded)] = model[static_cast<std::size_t>(m.model)];
  }
  return names;
}

template <typename Action>
std::string error_of(const Action& action) {
  try {
    action();
  } catch (const InputError& error) {
    return error.what();
  }
  return "no error";
}

TEST(MarkerMatching, SurerNamesGoFirst) {
  const Names recorded = {"Anna:lkne", "Anna:LKNE", "Anna:R Heel", "Anna:V.Sacral", "Anna:Wand"};
  const Names model = {"LKNE", "R.HEEL", "SACR", "RTOE"};
  const MarkerMatching matching = match(recorded, model);
  EXPECT_EQ(named(matching, recorded, model), (Names{"-", "LKNE", "R.HEEL", "SACR", "-"}));
  EXPECT_EQ(matching.count(MatchKind::kSame), 1);
  EXPECT_EQ(matching.count(MatchKind::kSpelling), 1);
  EXPECT_EQ(matching.count(MatchKind::kSite), 1);
  EXPECT_EQ(matching.unused, (std::vector<int>{0, 4}));
  EXPECT_EQ(matching.missing, (std::vector<int>{3}));
  EXPECT_EQ(matching.subject, "Anna");
}

// The same places in three sets, as their published descriptions name them.
TEST(MarkerMatching, SetsNameTheSamePlaces) {
  const Names plug_in = {"RASI", "LPSI", "RKNE", "RANK", "RHEE", "RTOE", "RSHO", "SACR"};
  const Names cleveland = {"R.ASIS", "L.PSIS", "R.Knee.Lat", "R.Ankle.Lat",
                           "R.Heel", "R.MT2",  "R.Acromium", "V.Sacral"};
  const Names calibrated = {"r asis", "LPSIS", "RLFC", "RLMAL", "RCAL", "RMT2", "RACR", "sacrum"};
  for (std::size_t i = 0; i < plug_in.size(); ++i) {
    EXPECT_FALSE(marker_site(plug_in[i]).empty()) << plug_in[i];
    EXPECT_EQ(marker_site(plug_in[i]), marker_site(cleveland[i])) << cleveland[i];
    EXPECT_EQ(marker_site(plug_in[i]), marker_site(calibrated[i])) << calibrated[i];
  }
  EXPECT_NE(marker_site("RKNE"), marker_site("LKNE"));
  EXPECT_NE(marker_site("R.Knee.Lat"), marker_site("R.Knee.Med"));
  // Wands, clusters and joint centres stand elsewhere in every laboratory.
  for (const char* name :
       {"RTH1", "LSK3", "RSHA", "R.Thigh.Upper", "LHJC", "RK", "Wand", "", "*12"}) {
    EXPECT_EQ(marker_site(name), "") << name;
  }
}

TEST(MarkerMatching, TakesTheSubjectWithMostMarkersOrTheOneThatIsSaid) {
  const Names recorded = {"Cart:LASI", "Anna:LASI", "Anna:RASI", "Ball"};
  const Names model = {"LASI", "RASI"};
  MarkerMatching matching = match(recorded, model);
  EXPECT_EQ(matching.subject, "Anna");
  EXPECT_EQ(matching.subjects, (Names{"Cart", "Anna"}));
  EXPECT_EQ(named(matching, recorded, model), (Names{"-", "LASI", "RASI", "-"}));
  EXPECT_TRUE(matching.unused.empty());
  MatchingOptions cart;
  cart.subject = "Cart";
  EXPECT_EQ(named(match(recorded, model, cart), recorded, model), (Names{"LASI", "-", "-", "-"}));
  cart.subject = "Bob";
  EXPECT_EQ(error_of([&] { match(recorded, model, cart); }),
            "walk.c3d: has no markers of that subject; expected Cart, Anna, found Bob. Correct "
            "--subject or leave it out.");
}

TEST(MarkerMatching, TheMapGoesBeforeNames) {
  const Names recorded = {"S:RKNE", "S:KneeOuter", "S:Spare"};
  const Names model = {"RKNE", "RTOE"};
  MatchingOptions options;
  options.map = {{"KneeOuter", "RKNE"}, {"S:RKNE", ""}, {"Spare", "RTOE"}};
  const MarkerMatching matching = match(recorded, model, options);
  EXPECT_EQ(named(matching, recorded, model), (Names{"-", "RKNE", "RTOE"}));
  EXPECT_EQ(matching.count(MatchKind::kSaid), 2);
  EXPECT_EQ(matching.unused, (std::vector<int>{0}));
  options.map = {{"KneeInner", "RKNE"}};
  EXPECT_EQ(error_of([&] { match(recorded, model, options); }),
            "walk.c3d: has no marker 'KneeInner', which the map names; expected S:KneeOuter. "
            "Correct the map.");
  options.map = {{"Spare", "RTO"}};
  EXPECT_EQ(error_of([&] { match(recorded, model, options); }),
            "walk.c3d: the model has no marker 'RTO', which the map names; expected RTOE. Correct "
            "the map.");
}

TEST(MarkerMatching, TooFewNamesTheNearest) {
  const Names recorded = {"LASI", "Knee_Rigt", "qqqq"}, model = {"LASI", "Knee_Right", "Heel"};
  const MarkerMatching matching = match(recorded, model);
  EXPECT_EQ(error_of([&] { require_matches(matching, 2, recorded, model, "walk.c3d"); }),
            "walk.c3d: only 1 of 3 recorded markers have a name that the model knows; not used: "
            "Knee_Rigt (Knee_Right?), qqqq; the model's: Knee_Right, Heel; expected 2 or more. "
            "Give --map MAP.csv with lines `recorded,model`, or a model with these markers.");
  EXPECT_NO_THROW(require_matches(matching, 1, recorded, model, "walk.c3d"));
}

TEST(MarkerMatching, RenamesAndKeepsWhatIsNotUsed) {
  MarkerTrajectories markers;
  markers.names = {"A:heel r", "B:LASI", "A:LASI", "A:box"};
  markers.rate = 100.0;
  markers.time = Eigen::VectorXd::Constant(1, 0.0);
  markers.frame_numbers = {7};
  markers.p_WM.resize(1, 12);
  for (int i = 0; i < 12; ++i) markers.p_WM(0, i) = i;
  const Names model = {"LASI", "Heel.R"};
  MatchingOptions options;
  options.subject = "A";
  const MarkerTrajectories named =
      rename_markers(markers, match(markers.names, model, options), model);
  EXPECT_EQ(named.names, (Names{"Heel.R", "LASI", "box"}));
  EXPECT_EQ(named.p_WM.row(0), (Eigen::RowVectorXd(9) << 0, 1, 2, 6, 7, 8, 9, 10, 11).finished());
  EXPECT_EQ(named.frame_numbers, markers.frame_numbers);
}

TEST(MarkerMap, IsReadAndWritten) {
  const TemporaryFolder folder;
  const MarkerMap map = {{"Anna:R Knee", "RKNE"}, {"box, big", ""}};
  folder.write("map.csv", "# of our laboratory\n" + marker_map_csv(map));
  EXPECT_EQ(read_marker_map(folder.path() / "map.csv"), map);
}

TEST(MarkerMap, TellsWhatIsWrong) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& content) {
    folder.write("map.csv", content);
    const std::string text = error_of([&] { read_marker_map(folder.path() / "map.csv"); });
    return text.substr(text.rfind("map.csv"));
  };
  EXPECT_EQ(error("RKNE,LKNE\n"),
            "map.csv:1: a map of markers begins with its labels; expected recorded,model, found "
            "RKNE,LKNE. Add this line.");
  EXPECT_EQ(error("recorded,model\nRKNE\n"),
            "map.csv:2: a row of a map has two names; expected recorded,model, found RKNE. Leave "
            "the model's name empty for markers that shall not be used.");
  EXPECT_EQ(error("recorded,model\na,b\nc,b\n"),
            "map.csv:3: a name stands twice in the map; expected each name once, found c,b. Remove "
            "one of the rows.");
  EXPECT_EQ(error("# nothing\n"),
            "map.csv: a map of markers begins with its labels; expected recorded,model");
}

TEST(NearestName, CountsEdits) {
  EXPECT_EQ(nearest_name("R.Kneee", {"L_Knee", "R Knee", "R.Ankle"}), "R Knee");
  EXPECT_EQ(nearest_name("abc", {"xyz"}), "");
}

TEST(MarkerSynonyms, WandsAndClustersMarkNoLandmark) {
  for (const char* name :
       {"RTHI", "LTIB", "Anna:RTHI", "R.Thigh.Upper", "L.Shank.Rear", "LTHAP", "RTIAD", "r_thigh2",
        "RUPA", "LFRM", "RBAK", "RTH1", "LSK3", "rshank1", "L_Cluster3"}) {
    EXPECT_TRUE(is_technical_marker(name)) << name;
  }
  for (const char* name :
       {"RKNE", "LANK", "RHEE", "R.Knee.Lat", "T10", "RTTC", "R_tibial_tuberosity", "Thorax", "TH1",
        "Leg", "LASI", "SACR", "rknee", "R.Toe.Tip", "V.Sacral", ""}) {
    EXPECT_FALSE(is_technical_marker(name)) << name;
  }
  EXPECT_EQ(technical_markers({"RKNE", "RTHI", "LTIB"}),
            (std::vector<std::string>{"RTHI", "LTIB"}));
}

}  // namespace
}  // namespace sinew
