#include "data/c3d_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <utility>

#include "data/c3d_bytes.h"
#include "data/c3d_frame_decoder.h"
#include "data/c3d_header.h"
#include "data/c3d_labels.h"
#include "data/c3d_layout.h"
#include "data/c3d_parameter_section.h"

namespace sinew {
namespace {

namespace fs = std::filesystem;

// Large enough that calls cost nothing, small enough to stay in the cache.
constexpr std::size_t kReadBytes = std::size_t{1} << 20;
// A section cannot declare more than 255 blocks, but may be longer; nobody knows larger ones.
constexpr std::uint64_t kMaxParameterBytes = std::uint64_t{64} << 20;

// The bytes of a file, by position.
class InputBytes {
 public:
  explicit InputBytes(const fs::path& path) : path_(path.string()) {
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) {
      throw InputError({path_, 0}, {"no such file", "", "", "Check the path and its spelling."});
    }
    if (!fs::is_regular_file(status)) {
      throw InputError({path_, 0}, {fs::is_directory(status) ? "is a folder" : "is no regular file",
                                    "a C3D file", "", "Name a file."});
    }
    stream_.open(path, std::ios::binary);
    size_ = fs::file_size(path, error);
    if (!stream_ || error) {
      throw InputError({path_, 0}, {fmt::format("cannot be opened ({})", std::strerror(errno)), "",
                                    "", "Check its permissions."});
    }
  }

  std::uint64_t size() const { return size_; }

  void read(std::uint64_t at, std::size_t count, char* out) {
    stream_.clear();
    stream_.seekg(static_cast<std::streamoff>(at));
    stream_.read(out, static_cast<std::streamsize>(count));
    if (stream_.gcount() == static_cast<std::streamsize>(count)) return;
    throw InputError({path_, 0},
                     {fmt::format("cannot be read at byte {}", at), fmt::format("{} bytes", count),
                      fmt::format("{}", stream_.gcount()), "Was the file changed meanwhile?"});
  }
  std::string text(std::uint64_t at, std::uint64_t count) {
    std::string result(static_cast<std::size_t>(count), '\0');
    read(at, result.size(), result.data());
    return result;
  }

 private:
  std::string path_;
  std::ifstream stream_;
  std::uint64_t size_ = 0;
};

const unsigned char* bytes_of(const std::string& text) {
  return reinterpret_cast<const unsigned char*>(text.data());
}

// The unit that makes the extent of a cloud of markers that of a person: most span 0.2 to 2.5 m, a
// foot or a racket alone less. Decimetres and inches are not guessed.
std::pair<std::string, double> judge_unit(double extent) {
  if (extent < 5.0) return {"m", 1.0};
  // A body in centimetres spans 20 to 250, a limb in millimetres hardly less than 150.
  if (extent < 150.0) return {"cm", 1e-2};
  return {"mm", 1e-3};
}

// The largest side of the box around points.
double largest_side(const std::vector<double>& coordinates) {
  double side = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    double low = coordinates[axis], high = low;
    for (std::size_t i = axis; i < coordinates.size(); i += 3) {
      low = std::min(low, coordinates[i]);
      high = std::max(high, coordinates[i]);
    }
    // A lone marker says something only by its distance from the origin.
    side = std::max(side, coordinates.size() > 3 ? high - low : std::abs(high));
  }
  return side;
}

}  // namespace

class C3dReader::Implementation {
 public:
  explicit Implementation(const fs::path& path) : bytes_(path) {
    file_.path = path.string();
    read_descriptions();
    c3d::PointNames names = c3d::name_everything(file_);
    file_.events = c3d::find_events(file_, file_.warnings);
    find_unit();
    if (const double rotations = find_number(file_.groups, "ROTATION", "USED").value_or(0.0);
        rotations > 0.0) {
      warn(fmt::format("the {} rotations of group ROTATION were not read", rotations));
    }
    decoder_.emplace(file_, std::move(names),
                     c3d::find_scales(file_.groups, file_.layout, file_.path, file_.warnings));
    scan();
  }

  const C3dFile& description() const { return file_; }
  std::int64_t frames_left() const { return file_.layout.frames - next_; }

  int read(int max_frames, C3dFrames& frames) {
    const auto count =
        static_cast<int>(std::min<std::int64_t>(std::max(max_frames, 0), frames_left()));
    resize(count, frames);
    frames.first = next_;
    for (int done = 0; done < count;) {
      const int part = load(next_ + done, count - done);
      const unsigned char* bytes = bytes_of(buffer_);
      for (int i = 0; i < part; ++i, bytes += file_.layout.frame_bytes) {
        decoder_->decode(bytes, done + i, frames);
      }
      done += part;
    }
    next_ += count;
    if (frames_left() == 0 && !finished_) finish();
    return count;
  }

 private:
  void warn(std::string text) { file_.warnings.push_back({{file_.path, 0}, std::move(text)}); }

  void read_descriptions() {
    // The pointer to the parameters is a byte.
    const std::string first = bytes_.text(0, std::min<std::uint64_t>(bytes_.size(), 256 * 512));
    const c3d::ParameterStart start = c3d::find_parameters(file_.path, first, file_.warnings);
    file_.header = c3d::parse_header(first, start.processor);
    const std::uint64_t begin = static_cast<std::uint64_t>(start.block - 1) * c3d::kBlock;
    const std::uint64_t declared = bytes_of(first)[begin + 2];
    const std::uint64_t end = std::min(begin + declared * c3d::kBlock, bytes_.size());
    const std::uint64_t records = begin + 4, bound = records_end(begin, end);
    file_.groups = c3d::parse_parameters(
        file_.path, bytes_.text(records, bound - records), static_cast<std::size_t>(records),
        static_cast<std::size_t>(end > records ? end - records : 0), start.processor,
        file_.warnings);
    file_.layout = c3d::find_layout(file_.path, file_.header, file_.groups, end, bytes_.size(),
                                    file_.warnings);
  }

  // Parameters may go on behind the blocks that they declare, but not into the data.
  std::uint64_t records_end(std::uint64_t begin, std::uint64_t declared_end) const {
    const std::uint64_t data =
        static_cast<std::uint64_t>(std::max(file_.header.data_block - 1, 0)) * c3d::kBlock;
    std::uint64_t end = data > begin ? data : declared_end;
    if (end < begin + c3d::kBlock) end = begin + c3d::kBlock;
    return std::min({end, bytes_.size(), begin + kMaxParameterBytes});
  }

  void find_unit() {
    const std::vector<std::string> units = find_texts(file_.groups, "POINT", "UNITS");
    const std::string unit = units.empty() ? "" : units.front();
    if (const auto metres = c3d::metres_per(unit)) {
      file_.unit = unit;
      file_.metres_per_unit = *metres;
    } else {
      unknown_unit_ = unit.empty() ? "POINT:UNITS is missing"
                                   : fmt::format("POINT:UNITS '{}' is no known length", unit);
    }
  }

  // Reads as far as it takes to see whether any point is measured and in which unit.
  void scan() {
    // Enough to get over a bad start.
    constexpr std::size_t kExtents = 100;
    if (file_.markers.names.empty() || file_.layout.frames == 0) return;
    std::vector<double> coordinates, measured_extents, flagged_extents;
    bool measured = false;
    const std::size_t wanted = unknown_unit_.empty() ? 1 : kExtents;
    for (std::int64_t i = 0; i < file_.layout.frames && measured_extents.size() < wanted;) {
      const int part = load(
          i, static_cast<int>(std::min<std::int64_t>(frames_per_load(), file_.layout.frames - i)));
      for (int k = 0; k < part && measured_extents.size() < wanted; ++k) {
        const bool now = decoder_->peek(
            bytes_of(buffer_) + static_cast<std::size_t>(k) * file_.layout.frame_bytes,
            coordinates);
        measured = measured || now;
        if (coordinates.empty()) continue;
        std::vector<double>& extents = now ? measured_extents : flagged_extents;
        if (extents.size() < kExtents) extents.push_back(largest_side(coordinates));
      }
      i += part;
    }
    if (!measured && !flagged_extents.empty()) {
      decoder_->keep_flagged();
      warn("every point is flagged as not measured, though coordinates are there; they were taken");
    }
    if (!unknown_unit_.empty()) judge(measured ? measured_extents : flagged_extents);
  }

  void judge(std::vector<double>& extents) {
    if (extents.empty()) return warn(unknown_unit_ + "; mm were assumed");
    const auto middle = extents.begin() + static_cast<std::ptrdiff_t>(extents.size() / 2);
    std::nth_element(extents.begin(), middle, extents.end());
    std::tie(file_.unit, file_.metres_per_unit) = judge_unit(*middle);
    decoder_->set_metres_per_unit(file_.metres_per_unit);
    warn(fmt::format("{}; markers span {:.4g}, so {} were taken", unknown_unit_, *middle,
                     file_.unit));
  }

  int frames_per_load() const {
    return static_cast<int>(std::max<std::uint64_t>(1, kReadBytes / file_.layout.frame_bytes));
  }

  // Puts at most `count` frames from the `first` on into the buffer; returns how many.
  int load(std::int64_t first, int count) {
    const int part = std::min(count, frames_per_load());
    buffer_.resize(static_cast<std::size_t>(part) * file_.layout.frame_bytes);
    bytes_.read(
        file_.layout.data_offset + static_cast<std::uint64_t>(first) * file_.layout.frame_bytes,
        buffer_.size(), buffer_.data());
    return part;
  }

  void resize(int count, C3dFrames& frames) const {
    const auto markers = static_cast<Eigen::Index>(file_.markers.names.size());
    frames.p_WM.resize(count, 3 * markers);
    frames.quality.residual.resize(count, markers);
    frames.quality.cameras.resize(count, markers);
    frames.computed.resize(count, 3 * file_.computed.count());
    frames.analog.resize(Eigen::Index{count} * file_.layout.analog_ratio,
                         file_.layout.analog_channels);
  }

  void finish() {
    finished_ = true;
    const c3d::PointCounts& counts = decoder_->counts();
    const auto warn_if = [&](std::int64_t count, const char* what) {
      if (count > 0) warn(fmt::format("{} marker samples {}", count, what));
    };
    warn_if(counts.zeros, "at exactly 0, 0, 0 were read as not measured");
    warn_if(counts.not_a_number, "are no positions without being flagged; read as not measured");
    warn_if(counts.by_65535, "are flagged by 65535 instead of -1; read as not measured");
    warn_if(counts.kept, "are flagged as not measured, but were taken");
  }

  InputBytes bytes_;
  C3dFile file_;
  std::optional<c3d::FrameDecoder> decoder_;
  std::string unknown_unit_;  // what is wrong with it
  std::string buffer_;
  std::int64_t next_ = 0;
  bool finished_ = false;
};

C3dReader::C3dReader(const fs::path& path)
    : implementation_(std::make_unique<Implementation>(path)) {}
C3dReader::~C3dReader() = default;
C3dReader::C3dReader(C3dReader&&) noexcept = default;
C3dReader& C3dReader::operator=(C3dReader&&) noexcept = default;

const C3dFile& C3dReader::description() const { return implementation_->description(); }
std::int64_t C3dReader::frames_left() const { return implementation_->frames_left(); }
int C3dReader::read(int max_frames, C3dFrames& frames) {
  return implementation_->read(max_frames, frames);
}

}  // namespace sinew
