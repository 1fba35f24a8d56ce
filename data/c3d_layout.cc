#include "data/c3d_layout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "data/c3d_bytes.h"

namespace sinew::c3d {
namespace {

constexpr std::int64_t kFullWord = 0xffff;  // where 16-bit counts end
// Of frames: two of them add up within an int, which frame numbers are. At 1 kHz, eleven days.
constexpr std::int64_t kMaxNumber = 1'000'000'000;

// Both are rounded to single precision in the file, more coarsely by some writers.
bool nearly_equal(double a, double b) { return std::abs(a - b) <= 1e-3 * std::abs(b); }

bool usable(double value) { return std::isfinite(value) && value > 0.0; }

// Numbers of a frame that may be right together.
struct Contents {
  int points = 0, channels = 0, ratio = 0;
  bool reals = true;

  std::uint64_t bytes() const {
    const auto samples = static_cast<std::uint64_t>(channels) * static_cast<std::uint64_t>(ratio);
    return (static_cast<std::uint64_t>(points) * 4 + samples) * (reals ? 4 : 2);
  }
};

class Weighing {
 public:
  Weighing(const std::string& path, const C3dHeader& header, const C3dGroups& groups,
           std::uint64_t parameters_end, std::uint64_t file_bytes, std::vector<Warning>& warnings)
      : path_(path),
        header_(header),
        groups_(groups),
        parameters_end_(parameters_end),
        file_bytes_(file_bytes),
        warnings_(warnings) {}

  C3dLayout weigh() {
    find_data();
    find_rate();
    find_scale();
    find_contents();
    find_first_frame();
    find_frames();
    return layout_;
  }

 private:
  template <typename... Values>
  void warn(fmt::format_string<Values...> format, Values&&... values) {
    warnings_.push_back({{path_, 0}, fmt::format(format, std::forward<Values>(values)...)});
  }

  double number(const char* group, const char* name, double otherwise,
                bool as_unsigned = false) const {
    const double value = find_number(groups_, group, name, as_unsigned).value_or(otherwise);
    return std::isfinite(value) ? value : otherwise;
  }
  // A count, or -1 where there is none.
  std::int64_t count(const char* group, const char* name) const {
    const double value = number(group, name, -1.0, true);
    return value >= 0.0 && value < kMaxNumber ? std::llround(value) : -1;
  }

  void find_data() {
    const auto data_at = [&](std::int64_t block) -> std::uint64_t {
      return block < 3 ? 0 : static_cast<std::uint64_t>(block - 1) * kBlock;
    };
    const std::uint64_t by_header = data_at(header_.data_block);
    const std::uint64_t by_parameter = data_at(count("POINT", "DATA_START"));
    const auto in_file = [&](std::uint64_t at) { return at > 0 && at <= file_bytes_; };
    if (in_file(by_header)) {
      layout_.data_offset = by_header;
    } else if (in_file(by_parameter)) {
      layout_.data_offset = by_parameter;
    } else if (header_.data_block >= 3) {
      fail_data(by_header);
    } else {
      layout_.data_offset = std::min(parameters_end_, file_bytes_);
    }
    if (layout_.data_offset != by_header) {
      warn("the header points to data in block {}; they were read from block {}",
           header_.data_block, layout_.data_offset / kBlock + 1);
    } else if (by_parameter != by_header && find_parameter(groups_, "POINT", "DATA_START")) {
      warn("POINT:DATA_START is {}, the header's is {}; the latter was used",
           count("POINT", "DATA_START"), header_.data_block);
    }
  }

  [[noreturn]] void fail_data(std::uint64_t at) const {
    throw InputError({path_, 0},
                     {fmt::format("the file ends before its data: the header points to byte {} "
                                  "(block {})",
                                  at, header_.data_block),
                      fmt::format("more than {} bytes", at), fmt::format("{}", file_bytes_),
                      "Was it written completely?"});
  }

  void find_rate() {
    const double by_parameter = number("POINT", "RATE", 0.0);
    const double camera = number("TRIAL", "CAMERA_RATE", 0.0);
    for (const double rate : {by_parameter, header_.rate, camera}) {
      if (layout_.rate == 0.0 && usable(rate)) layout_.rate = rate;
    }
    if (layout_.rate == 0.0) {
      throw InputError({path_, 0}, {"the rate of the frames is not known",
                                    "POINT:RATE or the header's rate above 0 Hz",
                                    fmt::format("{} and {}", by_parameter, header_.rate),
                                    "Write the recording's rate into POINT:RATE."});
    }
    if (!usable(by_parameter)) {
      warn("POINT:RATE is missing; the rate is {:.6g} Hz by the header", layout_.rate);
    } else if (!nearly_equal(header_.rate, by_parameter)) {
      warn("POINT:RATE is {:.6g} Hz, the header's rate {:.6g} Hz; the former was used",
           by_parameter, header_.rate);
    }
  }

  // The sign only says how numbers are stored. Writers that rescale data update the header.
  void find_scale() {
    const double by_parameter = number("POINT", "SCALE", 0.0);
    const bool has_header = std::isfinite(header_.scale) && header_.scale != 0.0;
    signed_scale_ = has_header ? header_.scale : by_parameter;
    if (signed_scale_ == 0.0) {
      warn("neither header nor POINT:SCALE gives a scale; data were taken for reals");
      signed_scale_ = -1.0;
    }
    layout_.scale = std::abs(signed_scale_);
    if (by_parameter == 0.0 && has_header) {
      warn("POINT:SCALE is missing; the header's {:.6g} was used", header_.scale);
    } else if (has_header && !nearly_equal(std::abs(by_parameter), layout_.scale)) {
      warn("POINT:SCALE is {:.6g}, the header's scale {:.6g}; the latter was used", by_parameter,
           header_.scale);
    }
    other_format_ = by_parameter * signed_scale_ < 0.0;
  }

  // The parameters' own numbers first.
  std::vector<Contents> possible_contents() const {
    const auto limited = [](std::int64_t value) {
      return static_cast<int>(std::clamp<std::int64_t>(value, -1, kFullWord));
    };
    const int used = limited(count("POINT", "USED")), channels = limited(count("ANALOG", "USED"));
    const double rates = number("ANALOG", "RATE", 0.0) / layout_.rate;
    const int by_rates = usable(rates) && rates < kFullWord ? limited(std::llround(rates)) : 0;
    std::vector<std::pair<int, int>> analogs;  // channels and ratio
    if (channels >= 0) {
      analogs.push_back({channels, std::max(1, header_.analog_ratio)});
      if (by_rates > 0) analogs.push_back({channels, by_rates});
      if (channels > 0 && header_.analog_per_frame >= channels) {
        analogs.push_back({channels, header_.analog_per_frame / channels});
      }
    }
    const int ratio = std::max(1, header_.analog_ratio);
    analogs.push_back({header_.analog_per_frame / ratio, ratio});
    std::vector<Contents> all;
    for (const bool reals : {signed_scale_<0.0, signed_scale_> 0.0}) {
      if (reals != (signed_scale_ < 0.0) && !other_format_) continue;
      for (const int points : {used, header_.points}) {
        for (const auto& [number_of, per_frame] : analogs) {
          if (points >= 0) all.push_back({points, number_of, per_frame, reals});
        }
      }
    }
    return all;
  }

  // Whether some frame count fills the file up to the padding of its last block.
  bool fills_file(const Contents& contents) const {
    const std::uint64_t room = file_bytes_ - layout_.data_offset;
    for (const auto& [name, frames] : frame_counts()) {
      const auto wanted = static_cast<std::uint64_t>(frames);
      if (frames <= 0 || contents.bytes() == 0 || wanted > room / contents.bytes()) continue;
      if (room - wanted * contents.bytes() < kBlock) return true;
    }
    return false;
  }

  void find_contents() {
    const std::vector<Contents> all = possible_contents();
    const auto fits = [&](const Contents& contents) { return fills_file(contents); };
    const auto found = std::find_if(all.begin(), all.end(), fits);
    const Contents chosen = found == all.end() ? all.front() : *found;
    layout_.reals = chosen.reals;
    layout_.points = chosen.points;
    layout_.analog_channels = chosen.channels;
    layout_.analog_ratio = chosen.channels > 0 ? chosen.ratio : 0;
    layout_.frame_bytes = chosen.bytes();
    warn_of_contents();
  }

  void warn_of_contents() {
    const std::int64_t used = count("POINT", "USED"), channels = count("ANALOG", "USED");
    if (used >= 0 && used != header_.points) {
      warn("POINT:USED is {}, the header has {} points; {} were read", used, header_.points,
           layout_.points);
    } else if (used < 0 && header_.points > 0) {
      warn("POINT:USED is missing; the header's {} points were read", header_.points);
    }
    const std::int64_t samples = std::int64_t{layout_.analog_channels} * layout_.analog_ratio;
    if (samples != header_.analog_per_frame ||
        (channels >= 0 && channels != layout_.analog_channels)) {
      warn(
          "ANALOG:USED is {}, the header has {} samples a frame, {} of each channel; {} channels "
          "of {} samples were read",
          channels, header_.analog_per_frame, header_.analog_ratio, layout_.analog_channels,
          layout_.analog_ratio);
    }
    if (other_format_) {
      warn("the header's scale and POINT:SCALE differ in sign; data were read as {}",
           layout_.reals ? "reals" : "integers");
    }
    const double analog_rate = number("ANALOG", "RATE", 0.0);
    const double rate = layout_.rate * layout_.analog_ratio;
    if (samples > 0 && usable(analog_rate) && !nearly_equal(analog_rate, rate)) {
      warn("ANALOG:RATE is {:.6g} Hz, but {} samples a frame make {:.6g} Hz; the latter was used",
           analog_rate, layout_.analog_ratio, rate);
    }
  }

  // A field of TRIAL: a 32-bit number in two words, the lower one first; or -1.
  std::int64_t field(const char* name) const {
    const C3dParameter* parameter = find_parameter(groups_, "TRIAL", name);
    const std::vector<double> words = parameter ? parameter->numbers(true) : std::vector<double>();
    if (words.empty() || !(words[0] >= 0.0) || words[0] > kMaxNumber) return -1;
    const auto low = static_cast<std::int64_t>(words[0]);
    if (words.size() < 2 || !(words[1] >= 0.0) || words[1] > kFullWord) return low;
    return std::min(low + (static_cast<std::int64_t>(words[1]) << 16), kMaxNumber);
  }

  std::vector<std::pair<const char*, std::int64_t>> frame_counts() const {
    const std::int64_t start = field("ACTUAL_START_FIELD"), end = field("ACTUAL_END_FIELD");
    std::int64_t by_header = std::int64_t{header_.last_frame} - header_.first_frame + 1;
    if (by_header <= 0 && header_.last_frame > 0) by_header += kFullWord + 1;  // wrapped around
    if (header_.last_frame == kFullWord && end > kFullWord) by_header = -1;  // as far as it counts
    return {{"TRIAL:ACTUAL_START_FIELD and ACTUAL_END_FIELD",
             start >= 0 && end >= start ? end - start + 1 : -1},
            {"POINT:LONG_FRAMES", count("POINT", "LONG_FRAMES")},
            {"POINT:FRAMES", count("POINT", "FRAMES")},
            {"the header", by_header}};
  }

  void find_first_frame() {
    layout_.first_frame = header_.first_frame;
    const std::int64_t start = field("ACTUAL_START_FIELD");
    if (start < 0 || start == header_.first_frame) return;
    if ((start & kFullWord) == header_.first_frame || header_.first_frame == kFullWord) {
      layout_.first_frame = start;
    } else {
      warn("TRIAL:ACTUAL_START_FIELD is {}, the header's first frame {}; the latter was used",
           start, header_.first_frame);
    }
  }

  void find_frames() {
    if (layout_.frame_bytes == 0) {
      layout_.frames = 0;
      warn("the file has neither points nor analog channels");
      return;
    }
    const std::uint64_t room = file_bytes_ - layout_.data_offset;
    const auto whole =
        static_cast<std::int64_t>(std::min<std::uint64_t>(room / layout_.frame_bytes, kMaxNumber));
    std::int64_t promised = -1;
    bool saturated = false;
    for (const auto& [name, frames] : frame_counts()) {
      promised = std::max(promised, frames);
      if (frames >= 0 && frames <= whole) layout_.frames = std::max(layout_.frames, frames);
      saturated = saturated || frames == kFullWord;
    }
    // A frame may be shorter than the padding of the last block. Then the header decides.
    const std::int64_t by_header = frame_counts().back().second;
    if (by_header > 0 && by_header <= layout_.frames &&
        room - static_cast<std::uint64_t>(by_header) * layout_.frame_bytes < kBlock) {
      layout_.frames = by_header;
    }
    if (promised > 0 && whole == 0) fail_frames(room);
    if (promised > whole) {
      if (layout_.frames == 0) layout_.frames = whole;
    } else if (promised <= 0 || (saturated && layout_.frames == kFullWord)) {
      layout_.frames = whole;
    }
    warn_of_frames(whole);
  }

  [[noreturn]] void fail_frames(std::uint64_t room) const {
    throw InputError({path_, 0},
                     {fmt::format("the file ends within its first frame, which begins at byte {}",
                                  layout_.data_offset),
                      fmt::format("{} bytes", layout_.frame_bytes), fmt::format("{}", room),
                      "Was it written completely?"});
  }

  void warn_of_frames(std::int64_t whole) {
    std::string counts;
    bool differ = false, too_many = false;
    for (const auto& [name, frames] : frame_counts()) {
      if (frames < 0) continue;
      counts += fmt::format("{}{} ({})", counts.empty() ? "" : ", ", frames, name);
      // Words of 16 bits cannot say more.
      const bool full = layout_.frames > kFullWord && frames <= kFullWord;
      differ = differ || (frames != layout_.frames && !full);
      too_many = too_many || frames > whole;
    }
    if (layout_.frames == whole && too_many && layout_.frames > 0) {
      warn("the file promises {} frames, but ends after {} whole ones, at byte {}; these were read",
           counts, whole, file_bytes_);
    } else if (differ) {
      warn("{} frames were read; the file promises {}", layout_.frames, counts);
    }
  }

  const std::string& path_;
  const C3dHeader& header_;
  const C3dGroups& groups_;
  const std::uint64_t parameters_end_, file_bytes_;
  std::vector<Warning>& warnings_;
  C3dLayout layout_;
  double signed_scale_ = -1.0;
  bool other_format_ = false;  // the two scales differ in sign
};

}  // namespace

C3dLayout find_layout(const std::string& path, const C3dHeader& header, const C3dGroups& groups,
                      std::uint64_t parameters_end, std::uint64_t file_bytes,
                      std::vector<Warning>& warnings) {
  return Weighing(path, header, groups, parameters_end, file_bytes, warnings).weigh();
}

}  // namespace sinew::c3d
