#include "data/trc_file.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "data/numbers.h"
#include "data/open_end.h"
#include "data/output_file.h"
#include "data/text.h"
#include "data/trc_header.h"

namespace sinew {
namespace {

using text::Line;
using text::LineReader;
using trc::Header;
using trc::kLeadingCells;
using trc::Layout;
using Cells = std::vector<std::string_view>;

[[noreturn]] void fail(const std::string& path, int line, InputError::Parts parts) {
  throw InputError({path, line}, std::move(parts));
}

// Collects rows; each is checked before the next is read.
class RowParser {
 public:
  RowParser(const std::string& path, const Layout& layout, const std::vector<std::string>& names)
      : path_(path), layout_(layout), names_(names), width_(kLeadingCells + 3 * layout.markers) {}

  void parse(const Line& line) {
    split(line);
    frames_.push_back(parse_frame(line));
    times_.push_back(parse_time(line));
    for (std::size_t marker = 0; marker < layout_.markers; ++marker) parse_marker(line, marker);
  }

  void fill(MarkerTrajectories& markers) const {
    const auto rows = static_cast<Eigen::Index>(times_.size());
    markers.frame_numbers = frames_;
    markers.time = Eigen::Map<const Eigen::VectorXd>(times_.data(), rows);
    markers.p_WM = Eigen::Map<const RowMatrix>(p_WM_.data(), rows,
                                               static_cast<Eigen::Index>(3 * layout_.markers));
  }

  void add_warnings(std::vector<Warning>& warnings) const {
    for (const Tally* tally : {&zeros_, &partial_, &short_rows_}) {
      if (tally->count == 0) continue;
      warnings.push_back(
          {{path_, tally->line}, fmt::format(fmt::runtime(tally->text), tally->count)});
    }
  }

 private:
  // How often something odd was seen, and first on which line.
  struct Tally {
    const char* text;
    long long count = 0;
    int line = 0;

    void add(int at) {
      if (count++ == 0) line = at;
    }
  };

  void split(const Line& line) {
    const bool tabs = layout_.tabs && line.text.find('\t') != line.text.npos;
    tabs ? text::split_tabs(line.text, cells_) : text::split_words(line.text, cells_);
    while (cells_.size() > width_ && cells_.back().empty()) cells_.pop_back();
    if (cells_.size() == width_) return;
    // Spreadsheets leave out the tabs behind the last filled cell.
    const bool whole_markers =
        cells_.size() >= kLeadingCells && (cells_.size() - kLeadingCells) % 3 == 0;
    if (tabs && cells_.size() < width_ && whole_markers && line.terminated) {
      short_rows_.add(line.number);
      // Half of what is kept may be padding, else short rows under a huge header would ask for more
      // memory than the file's size warrants.
      padding_ += width_ - cells_.size();
      if (padding_ <= p_WM_.size() / 2 + kFreePadding) return cells_.resize(width_);
    }
    fail_row(line);
  }

  [[noreturn]] void fail_row(const Line& line) const {
    fail(path_, line.number,
         {"a row does not fit the markers",
          fmt::format("{} values: frame, time and three for each of {} markers", width_,
                      layout_.markers),
          fmt::format("{}", cells_.size()),
          line.terminated ? "Correct the row or the header."
                          : "It is the last row: was the file written completely?"});
  }

  int parse_frame(const Line& line) const {
    const std::optional<long long> frame = text::parse_integer(cells_[0]);
    if (frame && std::abs(*frame) <= std::numeric_limits<int>::max()) {
      return static_cast<int>(*frame);
    }
    fail(path_, line.number,
         {"the frame number is no whole number", "a frame number", std::string(cells_[0]),
          "Correct the first cell of the row."});
  }

  double parse_time(const Line& line) const {
    const std::optional<double> time = text::parse_number(cells_[1]);
    if (!time || !std::isfinite(*time)) {
      fail(path_, line.number,
           {"the time is no number", "a time in seconds", std::string(cells_[1]),
            text::remedy_for_number(cells_[1])});
    }
    if (!times_.empty() && *time <= times_.back()) {
      fail(path_, line.number,
           {"time does not increase",
            fmt::format("more than {} s, the time of the row before",
                        text::format_number(times_.back())),
            std::string(cells_[1]), "Remove repeated rows and sort the others by time."});
    }
    return *time;
  }

  void parse_marker(const Line& line, std::size_t marker) {
    std::array<double, 3> p;
    int missing = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      p[axis] = parse_coordinate(line, marker, axis);
      if (std::isnan(p[axis])) ++missing;
    }
    const bool zero = p[0] == 0.0 && p[1] == 0.0 && p[2] == 0.0;
    if (zero) zeros_.add(line.number);
    if (missing == 1 || missing == 2) partial_.add(line.number);
    if (zero || missing > 0) p.fill(kNaN);
    p_WM_.insert(p_WM_.end(), p.begin(), p.end());
  }

  double parse_coordinate(const Line& line, std::size_t marker, std::size_t axis) const {
    const std::string_view cell = cells_[kLeadingCells + 3 * marker + axis];
    if (cell.empty()) return kNaN;
    const std::optional<double> value = text::parse_number(cell, layout_.decimal_shift);
    if (value && !std::isinf(*value)) return *value;
    fail(path_, line.number,
         {fmt::format("{} of marker '{}' is no number", "XYZ"[axis], names_[marker]),
          "a position, NaN or a blank cell", std::string(cell), text::remedy_for_number(cell)});
  }

  static constexpr std::size_t kFreePadding = 1 << 20;  // cells, 8 MiB

  const std::string& path_;
  const Layout layout_;
  const std::vector<std::string>& names_;
  const std::size_t width_;
  Cells cells_;
  std::size_t padding_ = 0;
  std::vector<int> frames_;
  std::vector<double> times_, p_WM_;
  Tally zeros_{"{} marker samples at exactly 0, 0, 0 were read as not measured"};
  Tally partial_{"{} marker samples lack one or two coordinates and were read as not measured"};
  Tally short_rows_{"{} rows end early; their last markers were read as not measured"};
};

void warn_of_header(const Header& header, MarkerFile& file) {
  const MarkerTrajectories& markers = file.markers;
  const auto warn = [&](std::string text) {
    file.warnings.push_back({{file.path, header.line}, std::move(text)});
  };
  if (header.frames != markers.frame_count()) {
    warn(
        fmt::format("the header promises NumFrames={}, the file has {} frames; all of them were "
                    "read",
                    header.frames, markers.frame_count()));
  }
  if (header.markers != markers.marker_count()) {
    warn(
        fmt::format("the header promises NumMarkers={}, the file has {} markers; all of them "
                    "were read",
                    header.markers, markers.marker_count()));
  }
  const Eigen::Index steps = markers.time.size() - 1;
  if (steps < 1) return;
  const double measured = static_cast<double>(steps) / (markers.time[steps] - markers.time[0]);
  // 2 % lets times pass that are rounded to milliseconds over a few frames; doubled and decimated
  // recordings are off by far more.
  if (std::abs(measured / header.rate - 1.0) > 0.02) {
    warn(fmt::format("the header's DataRate is {} Hz, the times step at {:.6g} Hz", header.rate,
                     measured));
  }
}

void check_sizes(const std::string& path, const MarkerTrajectories& markers) {
  const Eigen::Index frames = markers.time.size();
  const auto columns = static_cast<Eigen::Index>(3 * markers.names.size());
  if (markers.p_WM.rows() == frames && markers.p_WM.cols() == columns &&
      static_cast<Eigen::Index>(markers.frame_numbers.size()) == frames) {
    return;
  }
  fail(path, 0,
       {"write_trc got trajectories whose sizes disagree",
        fmt::format("{} frames, {} × {} positions", frames, frames, columns),
        fmt::format("{} frame numbers, {} × {} positions", markers.frame_numbers.size(),
                    markers.p_WM.rows(), markers.p_WM.cols()),
        ""});
}

void check_names(const std::string& path, const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (!text::trim(name).empty() && name.find_first_of("\t\r\n") == name.npos) continue;
    fail(path, 0,
         {"write_trc cannot write this marker name", "a name without tabs and line breaks", name,
          "Rename the marker."});
  }
}

std::string format_header(const std::string& file_name, const TrcWriter::Header& header) {
  const std::string rate = text::format_number(header.rate);
  std::string out = fmt::format("PathFileType\t4\t(X/Y/Z)\t{}\n", file_name);
  out +=
      "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits\tOrigDataRate\tOrigDataStartFrame\t"
      "OrigNumFrames\n";
  out += fmt::format("{0}\t{0}\t{1}\t{2}\tmm\t{0}\t{3}\t{1}\nFrame#\tTime", rate, header.frames,
                     header.names.size(), header.first_frame);
  for (const std::string& name : header.names) out += "\t" + name + "\t\t";
  out += "\n\t";
  for (std::size_t i = 1; i <= header.names.size(); ++i) {
    out += fmt::format("\tX{0}\tY{0}\tZ{0}", i);
  }
  return out + "\n\n";
}

// The shortest decimal that is this number of millimetres in 32 bits.
void append_single(std::string& out, double metres) {
  std::array<char, 64> buffer;  // -3.4e38 without exponent is 40 long
  const auto millimetres = static_cast<float>(1e3 * metres);
  const auto [end, error] = std::to_chars(buffer.data(), buffer.data() + buffer.size(), millimetres,
                                          std::chars_format::fixed);
  out.append(buffer.data(), end);
}

// Blocks that are large enough for the system's calls to cost nothing.
constexpr std::size_t kBlockBytes = std::size_t{1} << 20;

}  // namespace

TrcWriter::TrcWriter(const std::filesystem::path& path, const Header& header,
                     TrcPrecision precision)
    : path_(path.string()),
      coordinates_(3 * header.names.size()),
      frames_(header.frames),
      precision_(precision),
      file_((check_names(path.string(), header.names), path)),
      buffer_(format_header(path.filename().string(), header)) {}

void TrcWriter::append(std::int64_t frame_number, double time, const double* p_WM) {
  buffer_ += std::to_string(frame_number);
  buffer_ += '\t';
  buffer_ += text::format_number(time);
  for (std::size_t i = 0; i < coordinates_; ++i) {
    buffer_ += '\t';
    if (std::isnan(p_WM[i])) continue;
    if (precision_ == TrcPrecision::kSingle) {
      append_single(buffer_, p_WM[i]);
    } else {
      buffer_ += text::format_number(p_WM[i], 3);
    }
  }
  // OpenSim counts a blank cell at the end of a row only if a tab follows it.
  if (buffer_.back() == '\t') buffer_ += '\t';
  buffer_ += '\n';
  ++written_;
  if (buffer_.size() < kBlockBytes) return;
  file_.append(buffer_);
  buffer_.clear();
}

void TrcWriter::finish() {
  if (written_ != frames_) {
    fail(path_, 0,
         {"TrcWriter got another number of frames than its header says",
          fmt::format("{} frames", frames_), fmt::format("{}", written_), ""});
  }
  file_.append(buffer_);
  file_.commit();
}

MarkerFile read_trc(const std::filesystem::path& path) {
  const std::string content = text::read_text_file(path, "a TRC file");
  MarkerFile file;
  file.path = path.string();
  LineReader lines(content);
  const Header header = trc::parse_header(file.path, lines);
  file.markers.rate = header.rate;
  const Layout layout = trc::parse_columns(header, lines, file);
  RowParser rows(file.path, layout, file.markers.names);
  for (std::optional<Line> line = layout.first_row; line; line = lines.next_filled()) {
    rows.parse(*line);
  }
  rows.fill(file.markers);
  warn_of_header(header, file);
  rows.add_warnings(file.warnings);
  warn_of_open_end(file.path, content, file.warnings);
  return file;
}

void write_trc(const std::filesystem::path& path, const MarkerTrajectories& markers) {
  check_sizes(path.string(), markers);
  const int first = markers.frame_numbers.empty() ? 1 : markers.frame_numbers.front();
  TrcWriter writer(path, {markers.names, markers.rate, markers.frame_count(), first});
  for (Eigen::Index row = 0; row < markers.p_WM.rows(); ++row) {
    writer.append(markers.frame_numbers[static_cast<std::size_t>(row)], markers.time[row],
                  markers.p_WM.row(row).data());
  }
  writer.finish();
}

}  // namespace sinew
