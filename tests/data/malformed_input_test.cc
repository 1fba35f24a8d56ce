#include <gtest/gtest.h>

#include <functional>

#include "data/storage_file.h"
#include "data/tool_setup.h"
#include "data/trc_file.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

// A file that cannot be used, and the whole message that says so.
struct Case {
  const char* name;
  std::string content;
  std::string message;  // without the folder
};

void expect_messages(const std::string& file, const std::vector<Case>& cases,
                     const std::function<void(const std::filesystem::path&)>& read) {
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    const TemporaryFolder folder;
    const auto path = folder.write(file, c.content);
    EXPECT_EQ(error_of(folder.path(), [&] { read(path); }), c.message);
  }
}

const std::string kBinary("PathFileType\t4\0\0\1", 18);

// ---- TRC

const std::string kTrcKeys =
    "PathFileType\t4\t(X/Y/Z)\tt.trc\nDataRate\tNumFrames\tNumMarkers\tUnits\n";
const std::string kTrcHeader = kTrcKeys + "100\t2\t2\tmm\n";
const std::string kTrcNames = "Frame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n";
const std::string kTrcTop = kTrcHeader + kTrcNames;
const std::string kTrcRow = "1\t0\t1\t2\t3\t4\t5\t6\n";

const std::vector<Case> kTrcCases = {
    {"empty", "", "t.trc: is empty; expected a TRC file. Was it written completely?"},
    {"blank", " \n\t\n", "t.trc: is empty; expected a TRC file. Was it written completely?"},
    {"binary", kBinary,
     "t.trc: is binary or UTF-16; expected a TRC file in plain text. Is it the right file? Save it "
     "as "
     "UTF-8 text."},
    {"another format", "time\tx\n0\t1\n",
     "t.trc:1: is no TRC file; expected 'PathFileType' at its beginning, found time\\x09x. Is it "
     "the "
     "right file?"},
    {"only the first line", "PathFileType\t4\t(X/Y/Z)\tt.trc\n",
     "t.trc: ends before the header's field names; expected a complete TRC header and rows of "
     "data. "
     "Was the file written completely?"},
    {"no values", kTrcKeys,
     "t.trc: ends before the header's values; expected a complete TRC header and rows of data. Was "
     "the file written completely?"},
    {"no names", kTrcHeader,
     "t.trc: ends before the line of marker names; expected a complete TRC header and rows of "
     "data. "
     "Was the file written completely?"},
    {"no Units", "PathFileType\t4\nDataRate\tNumFrames\tNumMarkers\n100\t1\t2\n" + kTrcNames,
     "t.trc:2: the header has no Units; expected DataRate, NumFrames, NumMarkers and Units. Add "
     "the "
     "field."},
    {"blank Units", kTrcKeys + "100\t2\t2\n" + kTrcNames,
     "t.trc:3: the header's Units are not known; expected mm, cm or m. Write the unit of the "
     "marker "
     "positions."},
    {"wrong Units", kTrcKeys + "100\t2\t2\tinch\n" + kTrcNames,
     "t.trc:3: the header's Units are not known; expected mm, cm or m, found inch. Write the unit "
     "of "
     "the marker positions."},
    {"rate of zero", kTrcKeys + "0\t2\t2\tmm\n" + kTrcNames,
     "t.trc:3: the header's DataRate is no rate; expected frames per second, above 0, found 0. "
     "Write "
     "the rate of the recording."},
    {"rate in words", kTrcKeys + "fast\t2\t2\tmm\n" + kTrcNames,
     "t.trc:3: the header's DataRate is no rate; expected frames per second, above 0, found fast. "
     "Write the rate of the recording."},
    {"fractional frame count", kTrcKeys + "100\t2.5\t2\tmm\n" + kTrcNames,
     "t.trc:3: the header's NumFrames is no count; expected a whole number, 0 or more, found 2.5. "
     "Correct it; the rows of the file itself decide."},
    {"negative marker count", kTrcKeys + "100\t2\t-2\tmm\n" + kTrcNames,
     "t.trc:3: the header's NumMarkers is no count; expected a whole number, 0 or more, found -2. "
     "Correct it; the rows of the file itself decide."},
    {"no line of names", kTrcHeader + "1\t0\t1\t2\t3\n",
     "t.trc:4: the line of marker names is missing; expected 'Frame#', 'Time' and names, found "
     "1\\x090\\x091\\x092\\x093. Correct the header."},
    {"no marker", kTrcHeader + "Frame#\tTime\t\t\t\n",
     "t.trc:4: the file names no marker; expected marker names after 'Time'. Label the markers and "
     "export the file again."},
    {"coordinate labels cut",
     kTrcHeader + "Frame#\tTime\tA\t\t\tB\t\t\n\t\tX1\tY1\tZ1\tX2\n" + kTrcRow,
     "t.trc:5: the coordinate labels are incomplete; expected X, Y and Z for every marker, found 4 "
     "labels. Correct the header."},
    {"more names than coordinates",
     kTrcHeader + "Frame#\tTime\tA\tB\tC\n\t\tX1\tY1\tZ1\n" + kTrcRow,
     "t.trc:4: marker names and coordinates do not match; expected 1 names, one for each triple of "
     "coordinates, found 3. Name every marker, with one tab between the cells."},
    {"fewer names, out of place",
     kTrcHeader + "Frame#\tTime\t\tA\n\t\tX1\tY1\tZ1\tX2\tY2\tZ2\n" + kTrcRow,
     "t.trc:4: marker names and coordinates do not match; expected 2 names, one for each triple of "
     "coordinates, found 1. Name every marker, with one tab between the cells."},
    {"no rows", kTrcTop + "\n\n",
     "t.trc: has no rows of data; expected at least one frame. Was the file written completely?"},
    {"row too short", kTrcTop + "1\t0\t1\t2\t3\t4\t5\n",
     "t.trc:6: a row does not fit the markers; expected 8 values: frame, time and three for each "
     "of 2 "
     "markers, found 7. Correct the row or the header."},
    {"row too long", kTrcTop + "1\t0\t1\t2\t3\t4\t5\t6\t7\n",
     "t.trc:6: a row does not fit the markers; expected 8 values: frame, time and three for each "
     "of 2 "
     "markers, found 9. Correct the row or the header."},
    {"last row cut", kTrcTop + kTrcRow + "2\t0.01\t1\t2\t3",
     "t.trc:7: a row does not fit the markers; expected 8 values: frame, time and three for each "
     "of 2 "
     "markers, found 5. It is the last row: was the file written completely?"},
    {"blank cells between blanks", kTrcHeader + "Frame# Time A B\nX1 Y1 Z1 X2 Y2 Z2\n1 0 1 2 3\n",
     "t.trc:6: a row does not fit the markers; expected 8 values: frame, time and three for each "
     "of 2 "
     "markers, found 5. Correct the row or the header."},
    {"frame number in words", kTrcTop + "one\t0\t1\t2\t3\t4\t5\t6\n",
     "t.trc:6: the frame number is no whole number; expected a frame number, found one. Correct "
     "the "
     "first cell of the row."},
    {"huge frame number", kTrcTop + "3000000000\t0\t1\t2\t3\t4\t5\t6\n",
     "t.trc:6: the frame number is no whole number; expected a frame number, found 3000000000. "
     "Correct the first cell of the row."},
    {"time missing", kTrcTop + "1\t\t1\t2\t3\t4\t5\t6\n",
     "t.trc:6: the time is no number; expected a time in seconds. Correct the value."},
    {"time not a number", kTrcTop + "1\tNaN\t1\t2\t3\t4\t5\t6\n",
     "t.trc:6: the time is no number; expected a time in seconds, found NaN. Correct the value."},
    {"time repeats", kTrcTop + kTrcRow + "2\t0.000\t1\t2\t3\t4\t5\t6\n",
     "t.trc:7: time does not increase; expected more than 0 s, the time of the row before, found "
     "0.000. Remove repeated rows and sort the others by time."},
    {"decimal comma", kTrcTop + "1\t0\t1,5\t2\t3\t4\t5\t6\n",
     "t.trc:6: X of marker 'A' is no number; expected a position, NaN or a blank cell, found 1,5. "
     "Write decimals with a point, not a comma."},
    {"word for a coordinate", kTrcTop + "1\t0\t1\t2\t3\t4\t5\tlost\n",
     "t.trc:6: Z of marker 'B' is no number; expected a position, NaN or a blank cell, found lost. "
     "Correct the value."},
    {"infinite coordinate", kTrcTop + "1\t0\t1\t-Inf\t3\t4\t5\t6\n",
     "t.trc:6: Y of marker 'A' is no number; expected a position, NaN or a blank cell, found -Inf. "
     "Correct the value."},
};

TEST(MalformedInput, Trc) {
  expect_messages("t.trc", kTrcCases, [](const auto& path) { read_trc(path); });
}

// ---- MOT and STO

const std::vector<Case> kStorageCases = {
    {"empty", "", "t.sto: is empty; expected a MOT or STO file. Was it written completely?"},
    {"binary", kBinary,
     "t.sto: is binary or UTF-16; expected a MOT or STO file in plain text. Is it the right file? "
     "Save it as UTF-8 text."},
    {"no endheader", "t\nnRows=1\ntime x\n0 1\n",
     "t.sto: the header has no end; expected a line 'endheader', found none in 4 lines. Is it a "
     "MOT or "
     "STO file, and is it complete?"},
    {"nothing after the header", "t\nnRows=1\nendheader\n\n",
     "t.sto: has no column labels; expected a line of labels after 'endheader', found the end of "
     "the "
     "file. Was the file written completely?"},
    {"no time", "t\nendheader\nframe x\n0 1\n",
     "t.sto:3: no column is called time; expected the label 'time' among the column labels, found "
     "frame x. Add the time of every row, in seconds."},
    {"two times", "t\nendheader\ntime x Time\n0 1 2\n",
     "t.sto:3: two columns are called time; expected one, found columns 1 and 3. Remove or rename "
     "one."},
    {"rows in words", "t\nnRows=many\nendheader\ntime x\n0 1\n",
     "t.sto:2: the header's nRows is no count; expected a whole number, 0 or more, found many. "
     "Correct it; the rows of the file itself decide."},
    {"negative columns", "t\ndatacolumns -3\nendheader\ntime x\n0 1\n",
     "t.sto:2: the header's datacolumns is no count; expected a whole number, 0 or more, found -3. "
     "Correct it; the rows of the file itself decide."},
    {"huge rows", "t\nnRows=99999999999999999999\nendheader\ntime x\n0 1\n",
     "t.sto:2: the header's nRows is no count; expected a whole number, 0 or more, found "
     "99999999999999999999. Correct it; the rows of the file itself decide."},
    {"inDegrees unclear", "t\ninDegrees=maybe\nendheader\ntime x\n0 1\n",
     "t.sto:2: the header's inDegrees is neither yes nor no; expected yes or no, found maybe. "
     "Write "
     "inDegrees=yes if angles are in degrees, inDegrees=no for radians."},
    {"DataType unknown", "DataType=Mat33\nendheader\ntime x\n0 1\n",
     "t.sto:1: the header's DataType is not known; expected double, Vec2 to Vec12, UnitVec3, "
     "Quaternion "
     "or SpatialVec, found Mat33. Export the table as plain numbers."},
    {"DataType too large", "t\nDataType=Vec4000000\nendheader\ntime x\n0 1\n",
     "t.sto:2: the header's DataType is not known; expected double, Vec2 to Vec12, UnitVec3, "
     "Quaternion "
     "or SpatialVec, found Vec4000000. Export the table as plain numbers."},
    {"vector too short", "DataType=Vec3\nendheader\ntime\tp\n0\t1,2\n",
     "t.sto:4: column 'p' has a vector of the wrong size; expected 3 numbers separated by commas, "
     "found "
     "1,2. Correct the cell or the header's DataType."},
    {"vector too long", "DataType=Vec3\nendheader\ntime\tp\n0\t1,2,3,4\n",
     "t.sto:4: column 'p' has a vector of the wrong size; expected 3 numbers separated by commas, "
     "found "
     "1,2,3,4. Correct the cell or the header's DataType."},
    {"vector with a hole", "DataType=Vec3\nendheader\ntime\tp\n0\t1,,3\n",
     "t.sto:4: column 'p' has a value that is no number; expected a number. Correct the value."},
    {"row too short", "t\nendheader\ntime x y\n0 1 2\n1 2\n2 3 4\n",
     "t.sto:5: a row does not fit the column labels; expected 3 values, one for each label of line "
     "3, "
     "found 2. Correct the row or the labels."},
    {"row too long", "t\nendheader\ntime\tx\ty\n0\t1\t2\t3\n",
     "t.sto:4: a row does not fit the column labels; expected 3 values, one for each label of line "
     "3, "
     "found 4. Correct the row or the labels."},
    {"last row cut", "t\nendheader\ntime\tx\ty\n0\t1\t2\n1\t2",
     "t.sto:5: a row does not fit the column labels; expected 3 values, one for each label of line "
     "3, "
     "found 2. It is the last row: was the file written completely?"},
    {"last row cut behind a tab", "t\nendheader\ntime\tx\ty\n0\t1\t2\n1\t2\t",
     "t.sto:5: a row does not fit the column labels; expected 3 values, one for each label of line "
     "3, "
     "found 2. It is the last row: was the file written completely?"},
    {"column without a label", "t\nendheader\ntime\t\tx\n0\t1\t2\n",
     "t.sto:4: a row does not fit the column labels; expected 2 values, one for each label of line "
     "3, "
     "found 3. Correct the row or the labels."},
    {"word for a value", "t\nendheader\ntime x\n0 one\n",
     "t.sto:4: column 'x' has a value that is no number; expected a number, found one. Correct the "
     "value."},
    {"decimal comma", "t\nendheader\ntime x\n0 1,5\n",
     "t.sto:4: column 'x' has a value that is no number; expected a number, found 1,5. Write "
     "decimals "
     "with a point, not a comma."},
    {"value too large", "t\nendheader\ntime x\n0 1e999\n",
     "t.sto:4: column 'x' has a value that is no number; expected a number, found 1e999. Correct "
     "the "
     "value."},
    {"infinite time", "t\nendheader\ntime x\nInf 1\n",
     "t.sto:4: the time is no number; expected a time in seconds, found Inf. Correct the value."},
    {"blank time", "t\nendheader\nx\ttime\ty\n1\t\t2\n",
     "t.sto:4: the time is no number; expected a time in seconds. Correct the value."},
    {"time decreases", "t\nendheader\ntime x\n0.5 1\n0.4 2\n",
     "t.sto:5: time decreases; expected at least 0.5 s, the time of the row before, found 0.4. "
     "Sort the "
     "rows by time."},
    {"text after the rows", "t\nendheader\ntime x\n0 1\nend of file\n",
     "t.sto:5: a row does not fit the column labels; expected 2 values, one for each label of line "
     "3, "
     "found 3. Correct the row or the labels."},
};

TEST(MalformedInput, Storage) {
  expect_messages("t.sto", kStorageCases, [](const auto& path) { read_storage(path); });
}

// ---- Setups

std::string ik(const std::string& fields) {
  return "<InverseKinematicsTool>\n" + fields + "\n</InverseKinematicsTool>\n";
}
std::string tasks(const std::string& objects) {
  return ik("<IKTaskSet><objects>\n" + objects + "</objects></IKTaskSet>");
}

const std::vector<Case> kIkCases = {
    {"empty", "", "t.xml: is empty; expected an XML document. Was it written completely?"},
    {"wrong tool", "<OpenSimDocument>\n<ScaleTool/></OpenSimDocument>",
     "t.xml:1: holds no InverseKinematicsTool; expected an OpenSimDocument with "
     "<InverseKinematicsTool> or <InverseKinemtaticsTool> or <IKTool>, found OpenSimDocument with "
     "<ScaleTool>. Name the setup file of this tool."},
    {"a model", "<Model/>",
     "t.xml:1: holds no InverseKinematicsTool; expected an OpenSimDocument with "
     "<InverseKinematicsTool> or <InverseKinemtaticsTool> or <IKTool>, found Model. Name the setup "
     "file of this tool."},
    {"no tasks", ik("<model_file>m.osim</model_file>"),
     "t.xml:1: the tool has no <IKTaskSet>; expected tasks that say which markers to track. Add an "
     "<IKTaskSet>."},
    {"missing file of tasks", ik("<IKTaskSet file=\"gone.xml\"/>"),
     "t.xml:2: the file of the <IKTaskSet> does not exist; expected a file with the tasks, found "
     "gone.xml. Correct the attribute 'file'."},
    {"tasks that name themselves", ik("<IKTaskSet file=\"t.xml\"/>"),
     "t.xml:1: holds no IKTaskSet; expected an OpenSimDocument with <IKTaskSet>, found "
     "InverseKinematicsTool. Name the setup file of this tool."},
    {"one time", ik("<time_range>0.4</time_range>"),
     "t.xml:2: <time_range> is no range; expected two times in seconds, found 0.4. Give the first "
     "and "
     "the last time."},
    {"times reversed", ik("<time_range>2 1</time_range>"),
     "t.xml:2: <time_range> ends before it begins; expected the earlier time first, found 2 1. "
     "Exchange "
     "the two times."},
    {"times in words", ik("<time_range>start end</time_range>"),
     "t.xml:2: <time_range> holds a word that is no number; expected numbers separated by spaces, "
     "found "
     "start. Correct the value."},
    {"negative constraint weight", ik("<constraint_weight>-1</constraint_weight>"),
     "t.xml:2: <constraint_weight> is negative; expected 0 or more, or Inf, found -1. Correct the "
     "value."},
    {"constraint weight NaN", ik("<constraint_weight>NaN</constraint_weight>"),
     "t.xml:2: <constraint_weight> is NaN; expected a number. Correct the value."},
    {"accuracy of zero", ik("<accuracy>0</accuracy>"),
     "t.xml:2: <accuracy> is no accuracy; expected a number above 0, found 0. Correct the value."},
    {"unknown task", tasks("<IKPlaneTask name=\"p\"/>"),
     "t.xml:3: a task of an unknown kind; expected <IKMarkerTask> or <IKCoordinateTask>, found "
     "<IKPlaneTask>. Remove the task."},
    {"unnamed task", tasks("<IKMarkerTask><weight>1</weight></IKMarkerTask>"),
     "t.xml:3: <IKMarkerTask> has no name; expected the attribute 'name'. Name the marker or the "
     "coordinate."},
    {"negative weight", tasks("<IKMarkerTask name=\"A\">\n<weight>-2</weight></IKMarkerTask>"),
     "t.xml:4: <weight> of task 'A' is no weight; expected a finite number, 0 or more, found -2. "
     "Correct "
     "the value."},
    {"apply unclear", tasks("<IKMarkerTask name=\"A\"><apply>yes</apply></IKMarkerTask>"),
     "t.xml:3: <apply> is neither true nor false; expected true or false, found yes. Correct the "
     "value."},
    {"unknown value type",
     tasks("<IKCoordinateTask name=\"q\"><weight>1</weight><value_type>mean</value_type>"
           "</IKCoordinateTask>"),
     "t.xml:3: <value_type> of task 'q' is not known; expected default_value, manual_value or "
     "from_file, found mean. Correct the value."},
    {"infinite value",
     tasks("<IKCoordinateTask name=\"q\"><weight>1</weight><value>Inf</value></IKCoordinateTask>"),
     "t.xml:3: <value> of task 'q' is not finite; expected a number, found Inf. Correct the "
     "value."},
};

TEST(MalformedInput, IkSetup) {
  expect_messages("t.xml", kIkCases, [](const auto& path) { read_ik_setup(path); });
}

const std::vector<Case> kIdCases = {
    {"other analysis", "<AnalyzeTool><AnalysisSet><objects/></AnalysisSet></AnalyzeTool>",
     "t.xml:1: the AnalyzeTool does no inverse dynamics; expected <InverseDynamics> in its "
     "<AnalysisSet>, or an <InverseDynamicsTool>. Name the setup file of an inverse dynamics."},
    {"analysis ends first",
     "<AnalyzeTool><AnalysisSet><objects><InverseDynamics/></objects></AnalysisSet>\n"
     "<initial_time>2</initial_time>\n<final_time>1</final_time></AnalyzeTool>",
     "t.xml:3: <final_time> is before <initial_time>; expected at least 2, found 1. Correct the "
     "times."},
    {"two frequencies",
     "<InverseDynamicsTool>\n<lowpass_cutoff_frequency_for_coordinates>6 6"
     "</lowpass_cutoff_frequency_for_coordinates></InverseDynamicsTool>",
     "t.xml:2: <lowpass_cutoff_frequency_for_coordinates> has the wrong number of values; expected "
     "1, "
     "found 2. Give one number."},
    {"infinite ends", "<InverseDynamicsTool><time_range>NaN 1</time_range></InverseDynamicsTool>",
     "t.xml:1: <time_range> is no range; expected two times in seconds, found NaN 1. Give the "
     "first and "
     "the last time."},
};

TEST(MalformedInput, IdSetup) {
  expect_messages("t.xml", kIdCases, [](const auto& path) { read_id_setup(path); });
}

std::string loads(const std::string& objects) {
  return "<ExternalLoads><objects>\n" + objects + "</objects></ExternalLoads>";
}

const std::vector<Case> kLoadsCases = {
    {"cut", "<ExternalLoads><objects>\n<ExternalForce name=\"r\">",
     "t.xml:2: is not well-formed XML (Start-end tags mismatch). Is the file complete, and is it "
     "an XML "
     "file?"},
    {"old loads", loads("<PrescribedForce name=\"right\"/>"),
     "t.xml:2: external loads as PrescribedForce, from before OpenSim 2.4, are not supported; "
     "expected "
     "<ExternalForce>, found <PrescribedForce>. Open the file in OpenSim and save it again."},
    {"unknown load", loads("<Gravity/>"),
     "t.xml:2: an external load of an unknown kind; expected <ExternalForce>, found <Gravity>. "
     "Remove "
     "the load."},
    {"no body",
     loads("<ExternalForce name=\"r\"><force_identifier>f</force_identifier></ExternalForce>"),
     "t.xml:2: external force 'r' names no body; expected <applied_to_body>. Name the body that "
     "the "
     "force acts on."},
    {"no force",
     loads("<ExternalForce name=\"r\"><applied_to_body>b</applied_to_body>"
           "<force_identifier>Unassigned</force_identifier></ExternalForce>"),
     "t.xml:2: external force 'r' has neither force nor torque; expected <force_identifier> or "
     "<torque_identifier>. Name what the columns of the data begin with."},
    {"point without force",
     loads("<ExternalForce name=\"r\"><applied_to_body>b</applied_to_body>"
           "<point_identifier>p</point_identifier><torque_identifier>t</torque_identifier>"
           "</ExternalForce>"),
     "t.xml:2: external force 'r' has a point but no force; expected <force_identifier> beside "
     "<point_identifier>. Name the force's columns or remove the point's."},
    {"frequency in words",
     "<ExternalLoads>\n<lowpass_cutoff_frequency_for_load_kinematics>six"
     "</lowpass_cutoff_frequency_for_load_kinematics></ExternalLoads>",
     "t.xml:2: <lowpass_cutoff_frequency_for_load_kinematics> holds a word that is no number; "
     "expected "
     "numbers separated by spaces, found six. Correct the value."},
};

TEST(MalformedInput, ExternalLoads) {
  expect_messages("t.xml", kLoadsCases, [](const auto& path) { read_external_loads(path); });
}

TEST(MalformedInput, ExternalLoadsThatDoNotFitTheirData) {
  const TemporaryFolder folder;
  const auto error = [&](const std::string& data) {
    folder.write("grf.mot", data);
    const auto path =
        folder.write("t.xml",
                     "<ExternalLoads><objects>\n<ExternalForce name=\"r\"><applied_to_body>b"
                     "</applied_to_body><force_identifier>f_v</force_identifier></ExternalForce>"
                     "</objects><datafile>grf.mot</datafile></ExternalLoads>");
    return error_of(folder.path(), [&] { read_external_loads(path); });
  };
  const auto misfit = [](int count) {
    return "t.xml:2: <force_identifier> 'f_v' of external force 'r' does not fit the columns of "
           "grf.mot; expected exactly 3 labels that begin with it, found " +
           std::to_string(count) + ". Correct the identifier or the labels.";
  };
  EXPECT_EQ(error("t\nendheader\ntime f_px f_py f_pz\n"), misfit(0));
  EXPECT_EQ(error("t\nendheader\ntime f_vx f_vy\n"), misfit(2));
  EXPECT_EQ(error("t\nendheader\ntime f_vx f_vy f_vz f_vx f_vy f_vz\n"), misfit(6));
  EXPECT_EQ(
      error("t\nendheader\n"),
      "grf.mot: has no column labels; expected a line of labels after 'endheader', found the end "
      "of the file. Was the file written completely?");
}

// ---- All readers

TEST(MalformedInput, MissingFilesAndFolders) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "folder");
  const std::vector<std::function<void(const std::filesystem::path&)>> readers = {
      [](const auto& path) { read_trc(path); },
      [](const auto& path) { read_storage(path); },
      [](const auto& path) { read_storage_labels(path); },
      [](const auto& path) { read_ik_setup(path); },
      [](const auto& path) { read_ik_task_set(path); },
      [](const auto& path) { read_id_setup(path); },
      [](const auto& path) { read_external_loads(path); }};
  for (const auto& read : readers) {
    EXPECT_EQ(error_of(folder.path(), [&] { read(folder.path() / "none"); }),
              "none: no such file. Check the path and its spelling.");
    EXPECT_EQ(error_of(folder.path(), [&] { read(folder.path() / "folder"); }),
              "folder: is a folder; expected a file. Name a file in it.");
  }
}

// Every prefix of a good file either reads or is refused; nothing else may happen.
TEST(MalformedInput, EveryPrefixReadsOrIsRefused) {
  const TemporaryFolder folder;
  const std::string trc = kTrcTop + "\n" + kTrcRow + "2\t0.01\t\t\t\tNaN\t1e-3\t6\r\n";
  const std::string sto =
      "t\nversion=1\nnRows=2\nnColumns=3\ninDegrees=yes\nendheader\ntime\ta\tb\n"
      "0\t1\t2\n1\tnan\t-3e+4\n";
  int refused = 0;
  for (const auto& [content, read] :
       {std::pair<std::string, std::function<void(const std::filesystem::path&)>>{
            trc, [](const auto& path) { read_trc(path); }},
        {sto, [](const auto& path) { read_storage(path); }}}) {
    for (std::size_t size = 0; size < content.size(); ++size) {
      const auto path = folder.write("prefix", content.substr(0, size));
      if (error_of(folder.path(), [&] { read(path); }) != "no error") ++refused;
    }
  }
  EXPECT_GT(refused, 150);
}

}  // namespace
}  // namespace sinew
