#include "model/whole_body_table.h"

#include <gtest/gtest.h>

#include <cctype>
#include <string>
#include <vector>

#include "model/whole_body.h"

namespace sinew {
namespace {

// The message of the body made from tables one of which has `from` replaced by `to` once.
std::string error_with(const std::string& name, const std::string& from, const std::string& to) {
  const std::string file = "model/whole_body/" + name + ".csv";
  std::vector<anatomy::EmbeddedTable> tables;
  std::string spoiled;
  for (const anatomy::EmbeddedTable& table : anatomy::whole_body_tables()) {
    tables.push_back(table);
    if (table.file != file) continue;
    spoiled = std::string(table.text);
    const std::size_t at = spoiled.find(from);
    if (at == std::string::npos) return "'" + from + "' does not stand in the table";
    spoiled.replace(at, from.size(), to);
  }
  for (anatomy::EmbeddedTable& table : tables) {
    if (table.file == file) table.text = spoiled;
  }
  try {
    whole_body({}, tables);
  } catch (const InputError& error) {
    const std::string text = error.what();
    const std::size_t line = text.find(':') + 1;
    EXPECT_EQ(text.substr(0, line), file + ":");
    EXPECT_TRUE(std::isdigit(static_cast<unsigned char>(text[line]))) << text;
    return text.substr(text.find(':', line) + 2);
  }
  return "no error";
}

struct SpoiledTable {
  const char* table;
  const char* from;
  const char* to;
  const char* error;
};

constexpr SpoiledTable kSpoiledTables[] = {
    {"joints", "bone,parent,x,", "bone,parent,",
     "column 'x' is missing; expected columns "
     "bone,parent,x,y,z,coordinates,axes,ranges,joint,coupling, found "
     "bone,parent,y,z,coordinates,axes,ranges,joint,coupling. Correct the header."},
    {"joints", "bone,parent,", "bone,bone,",
     "a column stands twice; expected columns "
     "bone,parent,x,y,z,coordinates,axes,ranges,joint,coupling, found bone. Correct the header."},
    {"joints", "bone,parent,", "bone,parents,",
     "a column is unknown; expected columns "
     "bone,parent,x,y,z,coordinates,axes,ranges,joint,coupling, found parents. Correct the "
     "header."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,",
     "the row has another number of fields than the header; expected 10, found 9. Add or remove "
     "commas."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,abc,",
     "field 'x' is unusable; expected a finite number, found abc. Correct the number."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,nan,",
     "field 'x' is unusable; expected a finite number, found nan. Correct the number."},
    {"joints", "L5,pelvis,-40,", "L5,pelvis,,",
     "field 'x' is unusable; expected a finite number, found nothing. Correct the number."},
    {"joints", "L5,pelvis,", "L5,T5,",
     "field 'parent' is unusable; expected ground or the bone of an earlier row, found T5. Correct "
     "the name or the order of the rows."},
    {"joints", "L5_extension L5_bending L5_rotation,Z X Y", "L5_extension L5_bending,Z X Y",
     "field 'axes' is unusable; expected as many as coordinates, 2, found Z X Y. Give each "
     "coordinate an axis."},
    {"joints", "Z X Y,-10:7 -3:3 -3:3", "Z X Y,-10:7 -3:3",
     "field 'ranges' is unusable; expected as many as coordinates, 3, found -10:7 -3:3. Give each "
     "coordinate a range."},
    {"joints", "Z X Y,-10:7", "Z X Y,10:-7",
     "field 'ranges' is unusable; expected low:high around the default, 0 unless given between "
     "them, found 10:-7. Correct the range."},
    {"joints", "Z X Y,-10:7", "Z X Y,-10",
     "field 'ranges' is unusable; expected 2 to 3 numbers joined by ':', found -10. Correct the "
     "numbers."},
    {"joints", "Z X Y,-10:7", "Z W Y,-10:7",
     "field 'axes' is unusable; expected X, Y, Z, -X, -Y, -Z or three numbers joined by ':', found "
     "W. Correct the axis."},
    {"joints", "Z 0.684:0.669:-0.290", "Z 0.684:0.669",
     "field 'axes' is unusable; expected 3 numbers joined by ':', found 0.684:0.669. Correct the "
     "numbers."},
    {"joints", "Z 0.684:0.669:-0.290", "Z 0:0:0",
     "field 'axes' is unusable; expected an axis that has a direction, found 0:0:0. Correct it."},
    {"joints", "Z X Y x y z", "Z X Y x x z",
     "field 'axes' is unusable; expected each shift once, found Z X Y x x z. Remove one of them."},
    {"joints", "0.65:knee_angle_r\n", "0.65:elbow_flex_r\n",
     "field 'coupling' is unusable; expected slope:coordinate, of an earlier row, for a joint of "
     "one coordinate, found 0.65:elbow_flex_r. Correct the coupling."},
    {"joints", "0.65:knee_angle_r\n", "half:knee_angle_r\n",
     "field 'coupling' is unusable; expected 1 numbers joined by ':', found half. Correct the "
     "numbers."},
    {"joints", "T12,L1,", "L3,L1,",
     "field 'bone' is unusable; expected a name that is not taken, found L3. Rename one of the "
     "bones."},
    {"segment_places", "thigh,femur_r", "thai,femur_r",
     "field 'segment' is unusable; expected a male segment of model/whole_body/segments.csv, found "
     "thai. Correct the name or add the row."},
    {"segments", "thigh,male,14.16,422.2", "thigh,male,14.16,",
     "field 'length_mm' is unusable; expected a finite number, found nothing. Correct the number."},
    {"segment_places", "head,pelvis", "head,neck",
     "field 'bone' is unusable; expected a bone of model/whole_body/joints.csv, found neck. "
     "Correct "
     "the name."},
    {"segment_places", "thigh,femur_r,0,0,0,-Y,X", "thigh,femur_r,0,0,0,-Y,Y",
     "field 'sagittal' is unusable; expected an axis square to 'along', found Y. Correct it."},
    {"bones", "T9,upper_trunk,0.1,", "T9,upper_trunk,0.2,",
     "field 'segment' is unusable; expected shares in model/whole_body/bones.csv that add up to 1, "
     "found 1.1 for upper_trunk. Correct the shares."},
    {"bones", "T9,upper_trunk,0.1,", "T9,upper_trunk,-0.1,",
     "field 'share' is unusable; expected 'rest' or a positive number, found -0.1. Correct the "
     "share."},
    {"bones", "L5,lower_trunk,0.1,", "L5,lower_trunk,1,",
     "field 'segment' is unusable; expected shares in model/whole_body/bones.csv below 1 in sum, "
     "found 1 for lower_trunk. Correct the shares."},
    {"bones", "L5,lower_trunk,0.1,", "L5,lower_trunk,rest,",
     "field 'share' is unusable; expected one rest, found another. Give it a number."},
    {"bones", "hallux_r,foot,0.056,35", "hallux_r,foot,0.056,350",
     "field 'share' is unusable; expected others that leave an inertia which a body can have, "
     "found "
     "rest. Make the others smaller or move them inward."},
    {"bones", "T12,middle_trunk,0.145", "T11,middle_trunk,0.145",
     "field 'bone' is unusable; expected each bone once, found T11. Remove one of the rows."},
    {"landmarks_leg", "asis_r,pelvis,", "asis_r,pelvic,",
     "field 'bone' is unusable; expected a bone of model/whole_body/joints.csv, found pelvic. "
     "Correct the name."},
    {"landmarks_leg", "aiis_r,pelvis,", "asis_r,pelvis,",
     "field 'landmark' is unusable; expected a name that is not taken, found asis_r. Rename one of "
     "them."},
    {"landmarks_leg", "asis_r,pelvis,", "asis,pelvis,",
     "field 'z' is unusable; expected 0, or a name that ends in _r, found 118. Name the side, or "
     "move it."},
    {"landmarks_leg", "lesser_trochanter_r,", "lesser_trochanter,",
     "field 'landmark' is unusable; expected a name that ends in _r, as its bone's does, found "
     "lesser_trochanter. Add the side."},
    {"virtual_links_leg", "achilles_r,tibia_r", "achilles_r,shin_r",
     "field 'bone' is unusable; expected a bone of model/whole_body/joints.csv, found shin_r. "
     "Correct the name."},
    {"wires_leg", "soleus_r,medial,muscle,detailed", "soleus_r,medial,muscle,fine",
     "field 'level' is unusable; expected simplified, detailed or both, found fine. Correct the "
     "level."},
    {"wires_leg", "soleus_r,medial,muscle,", "soleus_r,medial,rope,",
     "field 'kind' is unusable; expected muscle, tendon or ligament, found rope. Correct the "
     "kind."},
    {"wires_leg", "soleus_r,medial,", "soleus_r,central,",
     "field 'slip' is unusable; expected a wire's name that is not taken, found soleus_central_r. "
     "Name the slip."},
    {"wires_leg", "soleus_r,medial,muscle,detailed,1195,", "soleus_r,medial,muscle,detailed,0,",
     "field 'force' is unusable; expected a number above 0, at most 10000, found 0. Correct the "
     "number."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_deep_r @achilles_r",
     "field 'path' is unusable; expected landmarks of model/whole_body/landmarks_*.csv, found "
     "soleus_tibia_deep_r. Correct the name or add the landmark."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_low_r @tibia_r",
     "field 'path' is unusable; expected a virtual link of model/whole_body/virtual_links_*.csv, "
     "at "
     "level detailed, found @tibia_r. Correct the name, the level, or add the virtual link."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_low_r @achilles_r:1:2",
     "field 'path' is unusable; expected 3 numbers joined by ':', found 1:2. Correct the numbers."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "soleus_tibia_low_r",
     "field 'path' is unusable; expected two points or more, found soleus_tibia_low_r. Add "
     "points."},
    {"wires_leg", "soleus_tibia_low_r @achilles_r", "@achilles_r @achilles_r",
     "field 'path' is unusable; expected points 5 mm apart or more, found 0 mm. Correct the "
     "landmarks."},
    {"markers", "RTHI,femur_r", "THI,femur_r",
     "field 'marker' is unusable; expected a name that begins with R, on a bone of the right side, "
     "found THI. Rename it."},
    {"markers", "LASI,", "RASI,",
     "two markers are called 'RASI'; expected unique names. Rename one of them."},
};

TEST(WholeBodyTable, NamesTableLineAndFieldOfWhatIsUnusable) {
  for (const SpoiledTable& spoiled : kSpoiledTables) {
    EXPECT_EQ(error_with(spoiled.table, spoiled.from, spoiled.to), spoiled.error)
        << spoiled.table << ": " << spoiled.to;
  }
}

TEST(WholeBodyTable, AsksForEveryTable) {
  const auto all = anatomy::whole_body_tables();
  EXPECT_EQ(all.size(), 14u);
  for (std::size_t left_out = 0; left_out < all.size(); ++left_out) {
    std::vector<anatomy::EmbeddedTable> tables(all.begin(), all.end());
    tables.erase(tables.begin() + static_cast<std::ptrdiff_t>(left_out));
    std::string text = "no error";
    try {
      whole_body({}, tables);
    } catch (const InputError& error) {
      text = error.what();
    }
    EXPECT_EQ(text, std::string(all[left_out].file) +
                        ": the table is missing; expected a table of the body. Add the file and "
                        "build.");
  }
}

// Letters of a side stand at the end or before what is said of the name.
TEST(WholeBodyTable, TellsSidesByNames) {
  using anatomy::is_right;
  using anatomy::mirrored;
  EXPECT_EQ(mirrored("soleus_medial_r"), "soleus_medial_l");
  EXPECT_EQ(mirrored("knee_angle_r_beta"), "knee_angle_l_beta");
  EXPECT_EQ(mirrored("achilles_l"), "achilles_r");
  EXPECT_EQ(mirrored("L5"), "L5");
  EXPECT_EQ(mirrored("femur_rear"), "femur_rear");
  EXPECT_EQ(mirrored(""), "");
  EXPECT_TRUE(is_right("femur_r"));
  EXPECT_FALSE(is_right("femur_l"));
  EXPECT_FALSE(is_right("r"));
}

}  // namespace
}  // namespace sinew
