#include <fmt/format.h>
#include <gtest/gtest.h>

#include <bit>
#include <functional>

#include "data/c3d_file.h"
#include "data/c3d_writer.h"
#include "tests/data/test_files.h"

namespace sinew {
namespace {

// Markers A and B, channel Fx, two samples a frame, five frames; A walks along x.
C3dFile small_file() {
  C3dFile file;
  file.markers.names = {"A", "B"};
  file.markers.rate = 100.0;
  file.markers.frame_numbers = {1, 2, 3, 4, 5};
  file.markers.p_WM.resize(5, 6);
  for (int i = 0; i < 5; ++i) file.markers.p_WM.row(i) << 0.125 * i + 0.5, 1, 1, 0.5, 1, 2;
  file.analog = {.labels = {"Fx"},
                 .units = {"N"},
                 .rate = 200.0,
                 .samples_per_frame = 2,
                 .values = Eigen::VectorXd::LinSpaced(10, 1.0, 10.0)};
  file.events = {
      {.time = 0.01, .label = "Foot Strike", .context = "Left", .subject = "", .description = ""}};
  return file;
}

// The bytes of a good file, to be spoiled.
class Bytes {
 public:
  Bytes() {
    const TemporaryFolder folder;
    write_c3d(folder.path() / "a.c3d", small_file());
    text_ = content_of(folder.path() / "a.c3d");
  }
  Bytes(std::string text) : text_(std::move(text)) {}

  const std::string& text() const { return text_; }
  Bytes& cut(std::size_t size) {
    text_.resize(size);
    return *this;
  }
  Bytes& byte(std::size_t at, int value) {
    text_.at(at) = static_cast<char>(value);
    return *this;
  }
  // Words count from 1, as in the manual.
  Bytes& word(std::size_t number, int value) {
    return byte(2 * number - 2, value & 0xff).byte(2 * number - 1, value >> 8 & 0xff);
  }
  Bytes& real_at(std::size_t at, float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (std::size_t i = 0; i < 4; ++i) byte(at + i, static_cast<int>(bits >> (8 * i) & 0xff));
    return *this;
  }
  // Where the record of a parameter has its name, the first after a group of parameters.
  std::size_t name_of(const std::string& name, int group) const {
    const std::string start = {static_cast<char>(name.size()), static_cast<char>(group)};
    const std::size_t at = text_.find(start + name, 512);
    if (at == text_.npos) throw std::logic_error("no parameter " + name);
    return at + 2;
  }
  Bytes& rename(const std::string& name, int group, const std::string& other) {
    text_.replace(name_of(name, group), name.size(), other);
    return *this;
  }
  // Of a parameter of `rank` dimensions.
  std::size_t value_of(const std::string& name, int group, std::size_t rank) const {
    return name_of(name, group) + name.size() + 4 + rank;
  }
  std::size_t data() const { return (static_cast<unsigned char>(text_[16]) - 1u) * 512u; }

 private:
  std::string text_;
};

constexpr int kPoint = 1, kAnalog = 2, kEvent = 3;  // as write_c3d numbers the groups it makes

// What reading says: the error, or the warnings.
std::string verdict(const Bytes& bytes) {
  const TemporaryFolder folder;
  const auto path = folder.write("a.c3d", bytes.text());
  std::string warnings;
  const std::string error = error_of(folder.path(), [&] {
    for (const Warning& warning : read_c3d(path).warnings) warnings += warning.text + "\n";
  });
  return error == "no error" ? warnings : error;
}

struct Case {
  const char* name;
  std::function<Bytes()> make;
  std::string verdict;
};

const std::vector<Case>& error_cases() {
  static const std::vector<Case> cases = {
      {"empty", [] { return Bytes(""); },
       "a.c3d: is empty; expected a C3D file. Was it written completely?"},
      {"short", [] { return Bytes().cut(700); },
       "a.c3d: is too short for a C3D file; expected at least 1024 bytes: a header and parameters, "
       "found 700. Was it written completely?"},
      {"text", [] { return Bytes(std::string(2000, 'x')); },
       "a.c3d: is no C3D file; expected 0x50 as second byte, and a parameter section, found the "
       "bytes 78 78. Is it the right file?"},
      {"zeros", [] { return Bytes(std::string(4096, '\0')); },
       "a.c3d: is no C3D file; expected 0x50 as second byte, and a parameter section, found the "
       "bytes 00 00. Is it the right file?"},
      {"unknown processor", [] { return Bytes().byte(515, 99); },
       "a.c3d: is no C3D file; expected 0x50 as second byte, and a parameter section, found the "
       "bytes 02 50. Is it the right file?"},
      {"data beyond the file",
       [] { return Bytes().word(9, 9000).rename("DATA_START", kPoint, "START_DATA"); },
       "a.c3d: the file ends before its data: the header points to byte 4607488 (block 9000); "
       "expected more than 4607488 bytes, found 1536. Was it written completely?"},
      {"cut at the data", [] { return Bytes().cut(1024); },
       "a.c3d: the file ends within its first frame, which begins at byte 1024; expected 40 bytes, "
       "found 0. Was it written completely?"},
      {"cut within the first frame", [] { return Bytes().cut(1024 + 39); },
       "a.c3d: the file ends within its first frame, which begins at byte 1024; expected 40 bytes, "
       "found 39. Was it written completely?"},
      {"no rate", [] { return Bytes().real_at(20, 0.0f).rename("RATE", kPoint, "ETAR"); },
       "a.c3d: the rate of the frames is not known; expected POINT:RATE or the header's rate above "
       "0 Hz, found 0 and 0. Write the recording's rate into POINT:RATE."},
      {"rates that are none",
       [] {
         Bytes bytes;
         return bytes.real_at(20, -5.0f).real_at(bytes.value_of("RATE", kPoint, 0), INFINITY);
       },
       "a.c3d: the rate of the frames is not known; expected POINT:RATE or the header's rate above "
       "0 Hz, found 0 and -5. Write the recording's rate into POINT:RATE."},
  };
  return cases;
}

const std::vector<Case>& warning_cases() {
  static const std::vector<Case> cases = {
      {"good", [] { return Bytes(); }, ""},
      {"wrong key", [] { return Bytes().byte(1, 0x51); },
       "the header's second byte is 0x51 instead of 0x50; the file was read as C3D all the same\n"},
      {"no pointer to parameters", [] { return Bytes().byte(0, 0); },
       "the header points to parameters in block 0; they were found in block 2\n"},
      {"wrong pointer to parameters", [] { return Bytes().byte(0, 3); },
       "the header points to parameters in block 3; they were found in block 2\n"},
      {"too few blocks declared", [] { return Bytes().byte(514, 1); }, ""},
      {"no points in the parameters", [] { return Bytes().rename("USED", kPoint, "DESU"); },
       "POINT:USED is missing; the header's 2 points were read\n"},
      {"fewer points in the header", [] { return Bytes().word(2, 1); },
       "POINT:USED is 2, the header has 1 points; 2 were read\n"},
      {"more frames than there are", [] { return Bytes().cut(1024 + 3 * 40 + 17); },
       "the file promises 5 (POINT:FRAMES), 5 (the header) frames, but ends after 3 whole ones, at "
       "byte 1161; these were read\n"},
      {"one frame more by a parameter",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("FRAMES", kPoint, 0), 6);
       },
       "5 frames were read; the file promises 6 (POINT:FRAMES), 5 (the header)\n"},
      {"data pointer beyond the file", [] { return Bytes().word(9, 9000); },
       "the header points to data in block 9000; they were read from block 3\n"},
      {"no data pointer in the header", [] { return Bytes().word(9, 0); },
       "the header points to data in block 0; they were read from block 3\n"},
      {"no data pointer at all",
       [] { return Bytes().word(9, 0).rename("DATA_START", kPoint, "START_DATA"); },
       "the header points to data in block 0; they were read from block 3\n"},
      {"wrong data pointer in the parameters",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("DATA_START", kPoint, 0), 7);
       },
       "POINT:DATA_START is 7, the header's is 3; the latter was used\n"},
      {"rates that disagree", [] { return Bytes().real_at(20, 50.0f); },
       "POINT:RATE is 100 Hz, the header's rate 50 Hz; the former was used\n"},
      {"no rate in the parameters", [] { return Bytes().rename("RATE", kPoint, "ETAR"); },
       "POINT:RATE is missing; the rate is 100 Hz by the header\n"},
      {"no scale", [] { return Bytes().real_at(12, 0.0f).rename("SCALE", kPoint, "ELACS"); },
       "neither header nor POINT:SCALE gives a scale; data were taken for reals\n"},
      {"signs of scales that disagree", [] { return Bytes().real_at(12, 1.0f); },
       "the header's scale and POINT:SCALE differ in sign; data were read as integers\n2 marker "
       "samples at exactly 0, 0, 0 were read as not measured\n"},
      {"unknown unit",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("UNITS", kPoint, 1), 'q');
       },
       "POINT:UNITS 'qm' is no known length; markers span 1000, so mm were taken\n"},
      {"no unit", [] { return Bytes().rename("UNITS", kPoint, "STINU"); },
       "POINT:UNITS is missing; markers span 1000, so mm were taken\n"},
      {"no labels", [] { return Bytes().rename("LABELS", kPoint, "SLEBAL"); },
       "POINT:LABELS has 0 labels for 2; the others are called unnamed_1, unnamed_2, ...\n"},
      {"repeated labels",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("LABELS", kPoint, 2) + 1, 'A');
       },
       "POINT:LABELS repeats 1 labels; a second A is called A_2\n"},
      {"blank label",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("LABELS", kPoint, 2), ' ');
       },
       "1 of POINT:LABELS are blank; they are called unnamed_1, unnamed_2, ...\n"},
      {"ratio that disagrees", [] { return Bytes().word(3, 4).word(10, 4); },
       "ANALOG:RATE is 200 Hz, but 4 samples a frame make 400 Hz; the latter was used\n1 marker "
       "samples at exactly 0, 0, 0 were read as not measured\n"},
      {"rates of channels that disagree",
       [] {
         Bytes bytes;
         return bytes.real_at(bytes.value_of("RATE", kAnalog, 0), 500.0f);
       },
       "ANALOG:RATE is 500 Hz, but 2 samples a frame make 200 Hz; the latter was used\n"},
      {"no scales of channels", [] { return Bytes().rename("SCALE", kAnalog, "ELACS"); },
       "ANALOG:SCALE has 0 of 1 values; the others are taken as 1\n"},
      {"scale that is no number",
       [] {
         Bytes bytes;
         return bytes.real_at(bytes.value_of("SCALE", kAnalog, 1), NAN);
       },
       "the scales or offsets of 1 analog channels are no numbers; their samples are given as "
       "stored\n"},
      {"more events than times",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("USED", kEvent, 0), 9);
       },
       "EVENT:USED is 9, but EVENT:TIMES has 1; these were read\n"},
      {"unknown type of a parameter",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("UNITS", kAnalog, 2) - 4, 3);
       },
       "at byte 804: parameter UNITS has the unknown type 3 with 2 dimensions; it was left out\n"},
      {"parameter that reaches into the data",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.value_of("LABELS", kAnalog, 2) - 1, 255)
             .byte(bytes.value_of("LABELS", kAnalog, 2) - 2, 255);
       },
       "at byte 712: the list of parameters ends in parameter LABELS, whose 65025 values reach "
       "into the data; the 312 bytes from there to the data were not read\nANALOG:LABELS has 0 "
       "labels for 1; the others are called unnamed_1, unnamed_2, ...\nANALOG:SCALE has 0 of 1 "
       "values; the others are taken as 1\n"},
      {"record without a group",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.name_of("GEN_SCALE", kAnalog) - 1, 77);
       },
       "at byte 751: parameter GEN_SCALE belongs to group number 77, which is not declared\n"},
      {"group declared twice",
       [] {
         Bytes bytes;
         const std::size_t at = bytes.name_of("EVENT", -kEvent);
         return bytes.byte(at - 1, -kAnalog);
       },
       "at byte 516: group EVENT (number 2) is declared more than once; its parameters were put "
       "together\nat byte 854: parameter USED belongs to group number 3, which is not declared\n"},
      {"name that is none",
       [] {
         Bytes bytes;
         return bytes.byte(bytes.name_of("GEN_SCALE", kAnalog), 1);
       },
       "at byte 751: the list of parameters ends in what is no record; the 273 bytes from there to "
       "the data were not read\nANALOG:SCALE has 0 of 1 values; the others are taken as 1\n"},
      {"points at 0, 0, 0",
       [] {
         Bytes bytes;
         const std::size_t at = bytes.data();
         return bytes.real_at(at, 0.0f).real_at(at + 4, 0.0f).real_at(at + 8, 0.0f);
       },
       "1 marker samples at exactly 0, 0, 0 were read as not measured\n"},
      {"coordinate that is no number",
       [] {
         Bytes bytes;
         return bytes.real_at(bytes.data() + 44, NAN).real_at(bytes.data() + 56, -1e9f);
       },
       "2 marker samples are no positions without being flagged; read as not measured\n"},
      {"flagged by 65535",
       [] {
         Bytes bytes;
         return bytes.real_at(bytes.data() + 12, 65535.0f);
       },
       "1 marker samples are flagged by 65535 instead of -1; read as not measured\n"},
      {"all flagged",
       [] {
         Bytes bytes;
         for (std::size_t i = 0; i < 5; ++i) {
           bytes.real_at(bytes.data() + 40 * i + 12, -1.0f);
           bytes.real_at(bytes.data() + 40 * i + 28, -1.0f);
         }
         return bytes;
       },
       "every point is flagged as not measured, though coordinates are there; they were taken\n10 "
       "marker samples are flagged as not measured, but were taken\n"},
  };
  return cases;
}

TEST(C3dMalformed, ErrorsSayWhatIsWrong) {
  for (const Case& c : error_cases()) {
    SCOPED_TRACE(c.name);
    EXPECT_EQ(verdict(c.make()), c.verdict);
  }
  const TemporaryFolder folder;
  EXPECT_EQ(error_of(folder.path(), [&] { read_c3d(folder.path() / "b.c3d"); }),
            "b.c3d: no such file. Check the path and its spelling.");
  EXPECT_EQ(error_of(folder.path().parent_path(), [&] { read_c3d(folder.path()); }),
            folder.path().filename().string() + ": is a folder; expected a C3D file. Name a file.");
}

TEST(C3dMalformed, WarningsSayHowItWasUnderstood) {
  for (const Case& c : warning_cases()) {
    SCOPED_TRACE(c.name);
    EXPECT_EQ(verdict(c.make()), c.verdict);
  }
}

// Without the folder.
std::string warnings_of(const C3dFile& file) {
  std::string text;
  for (const Warning& warning : file.warnings) text += warning.text + "\n";
  return text;
}

// The header points to data far behind where they are: all between is no list of parameters.
TEST(C3dMalformed, DataAreNotTakenForParameters) {
  const TemporaryFolder folder;
  C3dFile file = small_file();
  file.events.clear();
  const int frames = 4000;
  file.analog = {};
  file.markers.frame_numbers.clear();
  file.markers.p_WM.resize(frames, 6);
  for (int i = 0; i < frames; ++i) {
    file.markers.frame_numbers.push_back(i + 1);
    // Bytes of these reals, from the left: a record of a name of two bytes in group 3, then more.
    for (int k = 0; k < 6; ++k) file.markers.p_WM(i, k) = 1e-3 * std::bit_cast<float>(0xc3c20302u);
  }
  write_c3d(folder.path() / "a.c3d", file);
  Bytes bytes(content_of(folder.path() / "a.c3d"));
  // The last record points to where data begin instead of to the end of the list.
  const std::size_t pointer = bytes.name_of("USED", 3) + 4, to_data = bytes.data() - pointer;
  bytes.byte(pointer, static_cast<int>(to_data & 0xff))
      .byte(pointer + 1, static_cast<int>(to_data >> 8));
  bytes.word(9, 200);
  const C3dFile read = read_c3d(folder.write("b.c3d", bytes.text()));
  EXPECT_EQ(read.groups.size(), 3u);  // POINT, ANALOG and FORCE_PLATFORM
  EXPECT_LE(read.warnings.size(), 5u);
}

TEST(C3dMalformed, FilesWithoutMarkersAreRead) {
  const TemporaryFolder folder;
  C3dFile file = small_file();
  file.markers.names.clear();
  file.markers.p_WM.resize(5, 0);
  write_c3d(folder.path() / "analog.c3d", file);
  const C3dFile analog = read_c3d(folder.path() / "analog.c3d");
  EXPECT_EQ(warnings_of(analog), "");
  EXPECT_EQ(analog.markers.frame_count(), 5);
  EXPECT_TRUE(identical(analog.analog.values, file.analog.values));

  file.analog = {};
  file.markers.p_WM.resize(0, 0);
  file.markers.frame_numbers.clear();
  set_parameter(file.groups, "ROTATION", C3dParameter::of_integers("USED", {}, {21}));
  write_c3d(folder.path() / "rotations.c3d", file);
  const C3dFile rotations = read_c3d(folder.path() / "rotations.c3d");
  EXPECT_EQ(warnings_of(rotations),
            "the file has neither points nor analog channels\n"
            "the 21 rotations of group ROTATION were not read\n");
  EXPECT_EQ(rotations.markers.frame_count(), 0);
}

TEST(C3dMalformed, IntegerSamplesWithoutSignAreRead) {
  const TemporaryFolder folder;
  write_c3d(folder.path() / "a.c3d", small_file(), {.integers = true});
  Bytes bytes(content_of(folder.path() / "a.c3d"));
  const double step = 10.0 / 32000.0;  // of the channel, whose largest value is 10 N
  // The first sample comes behind two points of four words. It and the offset count from 0.
  bytes.word(1 + bytes.data() / 2 + 8, 40000);
  const std::size_t offset = bytes.value_of("OFFSET", kAnalog, 1);
  bytes.byte(offset, 0).byte(offset + 1, 0x80);  // 32768
  const std::size_t format = bytes.value_of("FORMAT", kAnalog, 1);
  for (std::size_t i = 0; i < 6; ++i) bytes.byte(format + i, "UNSIGN"[i]);
  const C3dFile file = read_c3d(folder.write("b.c3d", bytes.text()));
  EXPECT_NEAR(file.analog.values(0, 0), (40000 - 32768) * step, 1e-6);
}

}  // namespace
}  // namespace sinew
