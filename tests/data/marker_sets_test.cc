#include "data/marker_sets.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <sstream>

#include "data/marker_matching.h"
#include "data/marker_synonyms.h"

namespace sinew {
namespace {

using Names = std::vector<std::string>;

Names words(const std::string& text) {
  std::istringstream stream(text);
  return {std::istream_iterator<std::string>(stream), {}};
}

// The markers of the three models that recordings are most often fitted to.
const Names kRajagopal = words(
    "RACR LACR C7 CLAV RASH RPSH LASH LPSH RSJC RUA1 RUA2 RUA3 RLEL RMEL RFAsuperior RFAradius "
    "RFAulna LSJC LUA1 LUA2 LUA3 LLEL LMEL LFAsuperior LFAradius LFAulna RASI LASI RPSI LPSI LHJC "
    "RHJC RTH1 RTH2 RTH3 RLFC RMFC RKJC RTB1 RTB2 RTB3 RLMAL RMMAL RAJC RCAL RTOE RMT5 LTH1 LTH2 "
    "LTH3 LLFC LMFC LKJC LTB1 LTB2 LTB3 LLMAL LMMAL LAJC LCAL LTOE LMT5 REJC LEJC");
const Names kGait2392 = words(
    "Sternum R.Acromium L.Acromium Top.Head R.ASIS L.ASIS V.Sacral R.Thigh.Upper R.Thigh.Front "
    "R.Thigh.Rear R.Knee.Lat R.Knee.Med R.Shank.Upper R.Shank.Front R.Shank.Rear R.Ankle.Lat "
    "R.Ankle.Med R.Heel R.Midfoot.Sup R.Midfoot.Lat R.Toe.Lat R.Toe.Med R.Toe.Tip L.Thigh.Upper "
    "L.Thigh.Front L.Thigh.Rear L.Knee.Lat L.Knee.Med L.Shank.Upper L.Shank.Front L.Shank.Rear "
    "L.Ankle.Lat L.Ankle.Med L.Heel L.Midfoot.Sup L.Midfoot.Lat L.Toe.Lat L.Toe.Med L.Toe.Tip");
const Names kWholeBody = words(
    "RASI LASI RPSI LPSI C7 T10 CLAV STRN RBAK RSHO LSHO RFHD LFHD RBHD LBHD RTHI LTHI RKNE LKNE "
    "RKNM LKNM RTIB LTIB RANK LANK RMED LMED RHEE LHEE RTOE LTOE RMT5 LMT5 RHLX LHLX RUPA LUPA "
    "RELB LELB RWRA LWRA RWRB LWRB RFRM LFRM RFIN LFIN RGTR LGTR RHFB LHFB RTTC LTTC RMT1 LMT1 "
    "RELM LELM RMC5 LMC5 SACR L3 T6");

// What a set calls the places that each model marks, written down from the sets' descriptions and
// the models' own: recorded, Rajagopal, Gait2392, whole body; `-` where a model has no marker
// there.
// `@` is the side.
const char* const kTruth = R"(
set CGM 2.6
@ASI @ASI @.ASIS @ASI
@PSI @PSI - @PSI
@THI - - @THI
@THAP - - -
@KNE @LFC @.Knee.Lat @KNE
@KNM @MFC @.Knee.Med @KNM
@TIAD - - -
@ANK @LMAL @.Ankle.Lat @ANK
@MED @MMAL @.Ankle.Med @MED
@HEE @CAL @.Heel @HEE
@SMH @TOE - @TOE
@FMH - @.Toe.Med @MT1
@VMH @MT5 @.Toe.Lat @MT5
@SHO @ACR @.Acromium @SHO
@ELB @LEL - @ELB
@WRA @FAradius - @WRA
@WRB @FAulna - @WRB
@FHD - - @FHD
C7 C7 - C7
T10 - - T10
CLAV CLAV - CLAV
STRN - - STRN
set Helen Hayes with medials
@.ASIS @ASI @.ASIS @ASI
@.Thigh - - -
@.Knee @LFC @.Knee.Lat @KNE
@.Knee.Medial @MFC @.Knee.Med @KNM
@.Shank - - -
@.Ankle @LMAL @.Ankle.Lat @ANK
@.Ankle.Medial @MMAL @.Ankle.Med @MED
@.Heel @CAL @.Heel @HEE
@.Toe @TOE - @TOE
@.Shoulder @ACR @.Acromium @SHO
@.Elbow @LEL - @ELB
@.Wrist - - -
V.Sacral - V.Sacral SACR
set Qualisys, landmarks with CAST clusters
@_IAS @ASI @.ASIS @ASI
@_IPS @PSI - @PSI
@_FTC - - @GTR
@_FLE @LFC @.Knee.Lat @KNE
@_FME @MFC @.Knee.Med @KNM
@_FAX - - @HFB
@_TTC - - @TTC
@_FAL @LMAL @.Ankle.Lat @ANK
@_TAM @MMAL @.Ankle.Med @MED
@_FCC @CAL @.Heel @HEE
@_FM1 - @.Toe.Med @MT1
@_FM2 @TOE - @TOE
@_FM5 @MT5 @.Toe.Lat @MT5
@_SAE @ACR @.Acromium @SHO
@_HLE @LEL - @ELB
@_HME @MEL - @ELM
@_RSP @FAradius - @WRA
@_USP @FAulna - @WRB
@_HM2 - - @FIN
@_HM5 - - @MC5
@_SK1 - - -
CV7 C7 - C7
SJN CLAV - CLAV
SXS - - STRN
set IOR
@ASIS @ASI @.ASIS @ASI
@PSIS @PSI - @PSI
@GT - - @GTR
@LE @LFC @.Knee.Lat @KNE
@ME @MFC @.Knee.Med @KNM
@HF - - @HFB
@TT - - @TTC
@LM @LMAL @.Ankle.Lat @ANK
@MM @MMAL @.Ankle.Med @MED
@CA @CAL @.Heel @HEE
@FM - @.Toe.Med @MT1
@SM @TOE - @TOE
@VM @MT5 @.Toe.Lat @MT5
set Qualisys sports
Waist@Front @ASI @.ASIS @ASI
@ShoulderTop @ACR @.Acromium @SHO
@ElbowOut @LEL - @ELB
@ElbowIn @MEL - @ELM
@Hand2 - - @FIN
@ThighFrontLow - - -
@KneeOut @LFC @.Knee.Lat @KNE
@KneeIn @MFC @.Knee.Med @KNM
@ShinFrontHigh - - -
@AnkleOut @LMAL @.Ankle.Lat @ANK
@AnkleIn @MMAL @.Ankle.Med @MED
@HeelBack @CAL @.Heel @HEE
@Forefoot2 @TOE - @TOE
@Forefoot5 @MT5 @.Toe.Lat @MT5
WaistBack - V.Sacral SACR
SpineThoracic2 - - -
HeadFront - - -
Chest - - -
set OpenPose, BODY_25
@Shoulder @SJC - -
@Elbow @EJC - -
@Wrist - - -
@Hip @HJC - -
@Knee @KJC - -
@Ankle @AJC - -
@Heel @CAL @.Heel @HEE
@BigToe - - @HLX
@SmallToe - - -
@Eye - - -
@Ear - - -
Nose - - -
Neck - - -
MidHip - - -
set OpenCap
@.ASIS_study @ASI @.ASIS @ASI
@.PSIS_study @PSI - @PSI
@_knee_study @LFC @.Knee.Lat @KNE
@_mknee_study @MFC @.Knee.Med @KNM
@_ankle_study @LMAL @.Ankle.Lat @ANK
@_mankle_study @MMAL @.Ankle.Med @MED
@_calc_study @CAL @.Heel @HEE
@_toe_study @TOE - @TOE
@_5meta_study @MT5 @.Toe.Lat @MT5
@_thigh1_study - - -
@_sh1_study - - -
@_lelbow_study @LEL - @ELB
@_melbow_study @MEL - @ELM
@_shoulder_study @ACR @.Acromium @SHO
@HJC_study @HJC - -
C7_study C7 - C7
)";

std::string on_side(std::string name, char side) {
  const std::size_t at = name.find('@');
  if (at != name.npos) name[at] = side;
  return name;
}

void expect_matches(const std::string& set, const std::vector<Names>& rows, const Names& model,
                    std::size_t column) {
  Names recorded, expected;
  for (const Names& row : rows) {
    for (const char side : {'R', 'L'}) {
      if (side == 'L' && row[0].find('@') == std::string::npos) continue;
      recorded.push_back(on_side(row[0], side));
      expected.push_back(on_side(row[column], side));
    }
  }
  const MarkerMatching matching = match_markers(recorded, model, {}, "walk.c3d");
  Names found(recorded.size(), "-");
  for (const MarkerMatch& m : matching.matches) {
    found[static_cast<std::size_t>(m.recorded)] = model[static_cast<std::size_t>(m.model)];
  }
  for (std::size_t i = 0; i < recorded.size(); ++i) {
    EXPECT_EQ(found[i], expected[i]) << set << ": " << recorded[i];
  }
}

TEST(MarkerSets, EachSetMatchesTheModelsMarkersAndNoOthers) {
  std::map<std::string, std::vector<Names>> sets;
  std::istringstream lines(kTruth);
  std::string set;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("set ")) {
      set = line.substr(4);
    } else if (!line.empty()) {
      sets[set].push_back(words(line));
      ASSERT_EQ(sets[set].back().size(), 4u) << line;
    }
  }
  ASSERT_EQ(sets.size(), 7u);
  for (const auto& [name, rows] : sets) {
    expect_matches(name, rows, kRajagopal, 1);
    expect_matches(name, rows, kGait2392, 2);
    expect_matches(name, rows, kWholeBody, 3);
  }
}

// A name that holds always means one place; short names of two sets may not, which is why some sets
// hold only where they are recorded.
TEST(MarkerSets, NoNameMeansTwoPlaces) {
  std::map<std::string, std::string> sites;
  for (const MarkerSet& set : marker_sets()) {
    EXPECT_FALSE(std::string(set.source).empty()) << set.name;
    if (set.least > 0) continue;
    for (const auto rows : {set.sides, set.midline}) {
      for (const MarkerSetRow& row : rows) {
        for (const std::string& name : words(row.names)) {
          const auto [found, is_new] = sites.emplace(name, row.site);
          EXPECT_EQ(found->second, row.site) << set.name << ": " << name;
        }
      }
    }
  }
}

TEST(MarkerSets, CompanyTellsWhatShortNamesMean) {
  // Cappozzo's letters beside ankles and knees of another laboratory: RLE is an elbow's there.
  EXPECT_EQ(marker_sites({"RLE", "RME", "RLK", "RLA", "RCA"})[0], "");
  EXPECT_EQ(marker_sites({"RLE", "RHF", "RTT", "RLM", "RCA"})[0], "r:kne");
  EXPECT_EQ(marker_sites({"LKnee", "LHeel", "C7"})[0], "l:kne");
  EXPECT_EQ(marker_sites({"LKnee", "MidHip", "Neck"})[0], "l:kjc");
  EXPECT_EQ(marker_sites({"left_knee", "nose", "left_eye"})[0], "l:kjc");
  // A key point is no epicondyle of the same spelling.
  const Names recorded = {"RKnee", "MidHip", "Neck"}, model = {"R.Knee"};
  EXPECT_TRUE(match_markers(recorded, model, {}, "walk.trc").matches.empty());
  // Beside LMA, ANK is medial, although the model's RANK is lateral.
  const Names apart = {"RANK", "RLMA", "RLKN", "RMKN", "RTUB"}, ankle = {"RANK", "RMED"};
  const MarkerMatching matching = match_markers(apart, ankle, {}, "walk.c3d");
  ASSERT_EQ(matching.matches.size(), 2u);
  EXPECT_EQ(matching.matches[0], (MarkerMatch{0, 1, MatchKind::kSite}));
  EXPECT_EQ(matching.matches[1], (MarkerMatch{1, 0, MatchKind::kSite}));
}

}  // namespace
}  // namespace sinew
