#include "data/c3d_writer.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "data/c3d_bytes.h"
#include "data/c3d_header.h"
#include "data/c3d_labels.h"
#include "data/c3d_parameter_section.h"
#include "data/c3d_writer_scales.h"
#include "data/output_file.h"

namespace sinew {
namespace {

constexpr std::int64_t kFullWord = 0xffff;
constexpr std::size_t kMaxInParameter = 255;  // what a dimension counts to
constexpr int kMaxGroups = 127;

std::int16_t as_word(std::int64_t value) {
  return static_cast<std::int16_t>(
      static_cast<std::uint16_t>(std::clamp<std::int64_t>(value, 0, kFullWord)));
}

class Writer {
 public:
  Writer(const std::string& path, const C3dFile& file, const C3dWriteOptions& options)
      : path_(path),
        file_(file),
        integers_(options.integers),
        frames_(file.markers.p_WM.rows()),
        markers_(file.markers.marker_count()),
        points_(markers_ + file.computed.count()),
        channels_(file.analog.channel_count()),
        ratio_(channels_ > 0 ? file.analog.samples_per_frame : 0) {
    check();
    first_frame_ = file.markers.frame_numbers.empty() ? 1 : file.markers.frame_numbers.front();
    scales_ = c3d::choose_scales(file, integers_);
  }

  std::string write() {
    update_groups();
    std::string parameters = c3d::format_parameters(path_, groups_);
    const std::size_t data_block = 2 + parameters.size() / c3d::kBlock;
    if (data_block > kFullWord) fail("the parameters take too many blocks", kFullWord, data_block);
    set("POINT",
        C3dParameter::of_integers("DATA_START", {}, {as_word(static_cast<int>(data_block))}));
    parameters = c3d::format_parameters(path_, groups_);
    std::string out = c3d::format_header(header(static_cast<int>(data_block))) + parameters;
    append_frames(out);
    out.resize((out.size() + c3d::kBlock - 1) / c3d::kBlock * c3d::kBlock, '\0');
    return out;
  }

 private:
  template <typename Limit, typename Found>
  [[noreturn]] void fail(const std::string& problem, Limit limit, Found found) const {
    throw InputError({path_, 0}, {"write_c3d: " + problem, fmt::format("at most {}", limit),
                                  fmt::format("{}", found), "Write fewer in one file."});
  }
  void expect(const char* what, Eigen::Index rows, Eigen::Index cols, Eigen::Index has_rows,
              Eigen::Index has_cols) const {
    if (rows == has_rows && cols == has_cols) return;
    throw InputError({path_, 0}, {fmt::format("write_c3d got {} of the wrong size", what),
                                  fmt::format("{} × {}", rows, cols),
                                  fmt::format("{} × {}", has_rows, has_cols), ""});
  }

  void check() const {
    const C3dAnalog& analog = file_.analog;
    expect("positions", frames_, 3 * markers_, file_.markers.p_WM.rows(),
           file_.markers.p_WM.cols());
    expect("frame numbers", frames_, 1,
           static_cast<Eigen::Index>(file_.markers.frame_numbers.size()), 1);
    if (file_.computed.count() > 0) {
      expect("computed trajectories", frames_, 3 * file_.computed.count(),
             file_.computed.values.rows(), file_.computed.values.cols());
    }
    if (channels_ > 0) {
      expect("samples", frames_ * ratio_, channels_, analog.values.rows(), analog.values.cols());
      expect("units of channels", channels_, 1, static_cast<Eigen::Index>(analog.units.size()), 1);
    }
    if (has_quality()) {
      expect("residuals", frames_, markers_, file_.quality.residual.rows(),
             file_.quality.residual.cols());
      expect("cameras", frames_, markers_, file_.quality.cameras.rows(),
             file_.quality.cameras.cols());
    }
    if (points_ > kFullWord) fail("too many points", kFullWord, points_);
    if (channels_ * ratio_ > kFullWord) {
      fail("too many samples in a frame", kFullWord, channels_ * ratio_);
    }
    if (!(file_.markers.rate > 0.0) || !std::isfinite(file_.markers.rate)) {
      throw InputError({path_, 0}, {"write_c3d got no rate", "a rate above 0 Hz",
                                    fmt::format("{}", file_.markers.rate), ""});
    }
  }
  bool has_quality() const { return file_.quality.residual.size() > 0; }

  void set(const char* group, C3dParameter parameter) {
    set_parameter(groups_, group, std::move(parameter));
  }
  void set_integer(const char* group, const char* name, std::int64_t value) {
    set(group, C3dParameter::of_integers(name, {}, {as_word(value)}));
  }
  void set_real(const char* group, const char* name, double value) {
    set(group, C3dParameter::of_reals(name, {}, {static_cast<float>(value)}));
  }
  // NAME, NAME2, ..., 255 in each.
  template <typename Value, typename Make>
  void set_all(const char* group, const std::string& name, const std::vector<Value>& values,
               const Make& make) {
    remove_parameters(groups_, group, name, false);
    std::size_t at = 0;
    for (int i = 1; i == 1 || at < values.size(); ++i) {
      const std::size_t end = std::min(values.size(), at + kMaxInParameter);
      const auto begin = values.begin() + static_cast<std::ptrdiff_t>(at);
      const std::vector<Value> part(begin, values.begin() + static_cast<std::ptrdiff_t>(end));
      set(group, make(i == 1 ? name : name + std::to_string(i), part));
      at = end;
    }
  }
  void set_texts(const char* group, const char* name, const std::vector<std::string>& texts) {
    set_all(group, name, texts, C3dParameter::of_texts);
  }

  void update_groups() {
    groups_ = file_.groups;
    update_points();
    update_channels();
    update_trial();
    update_events();
    if (find_group(groups_, "FORCE_PLATFORM") == nullptr) set_integer("FORCE_PLATFORM", "USED", 0);
    for (const C3dGroup& group : groups_) {
      if (group.id > kMaxGroups) fail("too many groups", kMaxGroups, groups_.size());
    }
  }

  void update_points() {
    std::vector<std::string> labels = file_.markers.names;
    labels.insert(labels.end(), file_.computed.labels.begin(), file_.computed.labels.end());
    set_integer("POINT", "USED", points_);
    set_real("POINT", "SCALE", signed_scale());
    set_real("POINT", "RATE", file_.markers.rate);
    set_integer("POINT", "DATA_START", 0);
    set_integer("POINT", "FRAMES", frames_);
    if (find_parameter(groups_, "POINT", "LONG_FRAMES")) {
      set_real("POINT", "LONG_FRAMES", static_cast<double>(frames_));
    }
    set("POINT", C3dParameter::of_text("UNITS", unit()));
    set_texts("POINT", "LABELS", labels);
    if (!find_parameter(groups_, "POINT", "DESCRIPTIONS")) {
      set_texts("POINT", "DESCRIPTIONS", std::vector<std::string>(labels.size()));
    }
  }

  // Lengths of parameters and computed trajectories are in it.
  std::string unit() const {
    if (c3d::metres_per(file_.unit) == file_.metres_per_unit) return file_.unit;
    throw InputError({path_, 0}, {"write_c3d got a unit that is not metres_per_unit",
                                  fmt::format("the name of {} m", file_.metres_per_unit),
                                  file_.unit, "Set C3dFile::unit."});
  }
  float signed_scale() const { return integers_ ? scales_.point : -scales_.point; }

  void update_channels() {
    set_integer("ANALOG", "USED", channels_);
    set_texts("ANALOG", "LABELS", file_.analog.labels);
    if (!find_parameter(groups_, "ANALOG", "DESCRIPTIONS")) {
      set_texts("ANALOG", "DESCRIPTIONS", std::vector<std::string>(file_.analog.labels.size()));
    }
    set_real("ANALOG", "GEN_SCALE", 1.0);
    remove_parameters(groups_, "ANALOG", "OFFSETS", true);
    const auto size = [](const auto& values) { return static_cast<int>(values.size()); };
    set_all("ANALOG", "SCALE", scales_.channel, [&](std::string name, std::vector<float> part) {
      const int count = size(part);
      return C3dParameter::of_reals(std::move(name), {count}, std::move(part));
    });
    set_all("ANALOG", "OFFSET", scales_.offset,
            [&](std::string name, std::vector<std::int16_t> part) {
              const int count = size(part);
              return C3dParameter::of_integers(std::move(name), {count}, std::move(part));
            });
    set_texts("ANALOG", "UNITS", file_.analog.units);
    set_real("ANALOG", "RATE", file_.markers.rate * std::max(ratio_, Eigen::Index{1}));
    set("ANALOG", C3dParameter::of_text("FORMAT", "SIGNED"));
  }

  void update_trial() {
    const std::int64_t last = first_frame_ + frames_ - 1;
    if (!find_parameter(groups_, "TRIAL", "ACTUAL_START_FIELD") && last <= kFullWord) return;
    const auto field = [&](const char* name, std::int64_t value) {
      const std::int64_t from_zero = std::max<std::int64_t>(value, 0);
      set("TRIAL", C3dParameter::of_integers(
                       name, {2}, {as_word(from_zero & kFullWord), as_word(from_zero >> 16)}));
    };
    field("ACTUAL_START_FIELD", first_frame_);
    field("ACTUAL_END_FIELD", last);
  }

  double stored_time(const C3dEvent& event) const {
    return event.time +
           static_cast<double>(std::max<std::int64_t>(first_frame_ - 1, 0)) / file_.markers.rate;
  }

  void update_events() {
    std::vector<std::string> labels, contexts, subjects, descriptions;
    std::vector<std::pair<float, float>> times;
    for (const C3dEvent& event : file_.events) {
      if (event.in_header) continue;
      const double time = stored_time(event);
      // Rounded first, so that 60 s read back are not written as 59.99.
      const double minutes = std::floor(static_cast<double>(static_cast<float>(time)) / 60.0);
      times.push_back({static_cast<float>(minutes), static_cast<float>(time - 60.0 * minutes)});
      labels.push_back(event.label);
      contexts.push_back(event.context);
      subjects.push_back(event.subject);
      descriptions.push_back(event.description);
    }
    if (labels.empty() && !find_group(groups_, "EVENT")) return;
    set_integer("EVENT", "USED", static_cast<std::int64_t>(labels.size()));
    set_texts("EVENT", "LABELS", labels);
    set_texts("EVENT", "CONTEXTS", contexts);
    set_texts("EVENT", "SUBJECTS", subjects);
    set_texts("EVENT", "DESCRIPTIONS", descriptions);
    set_all("EVENT", "TIMES", times, [](std::string name, const auto& part) {
      std::vector<float> values;
      for (const auto& [minutes, seconds] : part) values.insert(values.end(), {minutes, seconds});
      return C3dParameter::of_reals(std::move(name), {2, static_cast<int>(part.size())},
                                    std::move(values));
    });
  }

  C3dHeader header(int data_block) const {
    C3dHeader header;
    header.points = static_cast<int>(points_);
    header.analog_per_frame = static_cast<int>(channels_ * ratio_);
    header.first_frame = static_cast<int>(std::clamp<std::int64_t>(first_frame_, 0, kFullWord));
    header.last_frame =
        static_cast<int>(std::clamp<std::int64_t>(first_frame_ + frames_ - 1, 0, kFullWord));
    header.max_gap = file_.header.max_gap;
    header.scale = signed_scale();
    header.data_block = data_block;
    header.analog_ratio = static_cast<int>(ratio_);
    header.rate = file_.markers.rate;
    for (C3dEvent event : file_.events) {
      event.time = stored_time(event);
      if (event.in_header) header.events.push_back(std::move(event));
    }
    return header;
  }

  void put(std::string& out, double value) const {
    if (integers_) {
      const auto word = static_cast<std::uint16_t>(
          static_cast<std::int16_t>(std::clamp(std::round(value), -32768.0, 32767.0)));
      out += {static_cast<char>(word & 0xff), static_cast<char>(word >> 8)};
      return;
    }
    const auto bits = std::bit_cast<std::uint32_t>(static_cast<float>(value));
    for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(bits >> shift & 0xff);
  }

  // `p` in the file's unit.
  void put_point(std::string& out, Eigen::Vector3d p, double fourth) const {
    if (p.hasNaN()) {
      p.setZero();
      fourth = -1.0;
    } else if (integers_) {
      p /= scales_.point;
    }
    for (const double coordinate : p) put(out, coordinate);
    put(out, fourth);
  }

  // 0, 0, 0 would be read as not measured.
  void put_marker(std::string& out, Eigen::Vector3d p, double fourth) const {
    if (integers_ && p.cwiseAbs().maxCoeff() < 0.5 * scales_.point) p.x() = scales_.point;
    put_point(out, p, fourth);
  }

  double fourth_number(Eigen::Index frame, Eigen::Index marker) const {
    if (!has_quality()) return 0.0;
    const double residual = file_.quality.residual(frame, marker);
    const double steps = std::round(residual / file_.metres_per_unit / scales_.point);
    const int cameras = file_.quality.cameras(frame, marker) & 0x7f;
    return 256.0 * cameras + (steps > 0.0 ? std::min(steps, 255.0) : 0.0);
  }

  void append_frames(std::string& out) const {
    const auto values = static_cast<std::size_t>(frames_ * (4 * points_ + channels_ * ratio_));
    out.reserve(out.size() + values * (integers_ ? 2 : 4) + c3d::kBlock);
    for (Eigen::Index frame = 0; frame < frames_; ++frame) {
      for (Eigen::Index i = 0; i < markers_; ++i) {
        const Eigen::Vector3d p = file_.markers.p_WM.row(frame).segment<3>(3 * i);
        put_marker(out, p / file_.metres_per_unit, fourth_number(frame, i));
      }
      for (Eigen::Index i = 0; i < points_ - markers_; ++i) {
        put_point(out, file_.computed.values.row(frame).segment<3>(3 * i), 0.0);
      }
      for (Eigen::Index i = frame * ratio_; i < (frame + 1) * ratio_; ++i) append_samples(out, i);
    }
  }

  void append_samples(std::string& out, Eigen::Index row) const {
    for (Eigen::Index i = 0; i < channels_; ++i) {
      const auto channel = static_cast<std::size_t>(i);
      double value = file_.analog.values(row, i) / scales_.channel[channel];
      if (integers_ && std::isnan(value)) value = 0.0;
      put(out, value + scales_.offset[channel]);
    }
  }

  const std::string path_;
  const C3dFile& file_;
  const bool integers_;
  const Eigen::Index frames_, markers_, points_, channels_, ratio_;
  std::int64_t first_frame_ = 1;
  c3d::StoredScales scales_;
  C3dGroups groups_;
};

}  // namespace

void write_c3d(const std::filesystem::path& path, const C3dFile& file,
               const C3dWriteOptions& options) {
  write_file_atomically(path, Writer(path.string(), file, options).write());
}

}  // namespace sinew
