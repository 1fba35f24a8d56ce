#pragma once

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "data/input_error.h"
#include "tests/data/live_memory.h"
#include "tests/data/test_files.h"

/// Real files, cut and with flipped bytes. SINEW_BATTERY=200 makes 200 of each of every file, as
/// many as the variable says; without it there are a few.
namespace sinew {

/// What a reader made of a file.
struct Reading {
  std::string result;  // all of it, by a hash or as text
  std::string flags;   // what it warned of
};
using Reader = std::function<Reading(const std::filesystem::path&)>;

/// Adds bytes to a hash of 64 bits (FNV-1a).
class Fingerprint {
 public:
  void add(const void* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      hash_ = (hash_ ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3ull;
    }
  }
  void add(const std::string& text) { add(text.c_str(), text.size() + 1); }
  void add(const std::vector<std::string>& texts) {
    for (const std::string& text : texts) add(text);
  }
  // Values by eight bytes, -0 apart from 0; every NaN is one.
  template <typename Derived>
  void add(const Eigen::DenseBase<Derived>& values) {
    for (Eigen::Index i = 0; i < values.rows(); ++i) {
      for (Eigen::Index j = 0; j < values.cols(); ++j) {
        const double value = values.derived()(i, j);
        std::uint64_t bits = ~std::uint64_t{0};
        if (!std::isnan(value)) std::memcpy(&bits, &value, sizeof bits);
        hash_ = (hash_ ^ bits) * 0x100000001b3ull;
        hash_ ^= hash_ >> 29;
      }
    }
  }
  std::string text() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325ull;
};

/// Reads spoiled copies of files. A cut file must be refused, flagged or read as the whole one; of
/// one with a flipped byte no more can be asked than that it is refused or read: one digit is as
/// good as another. Nothing may crash, take more than a minute or more memory than `factor` times
/// the file and `constant`.
class Battery {
 public:
  Battery(std::string name, Reader reader, double factor, double constant)
      : name_(std::move(name)), reader_(std::move(reader)), factor_(factor), constant_(constant) {
    const char* wanted = std::getenv("SINEW_BATTERY");
    if (wanted != nullptr) places_ = std::max(1, std::atoi(wanted));
  }

  /// Whether cuts may go unnoticed: the format has nothing that says where a file ends.
  Battery& allow_silent_cuts() {
    silent_cuts_ = true;
    return *this;
  }

  /// `copies` go beside the spoiled file, for what it names.
  void run(const std::filesystem::path& path,
           const std::vector<std::filesystem::path>& copies = {}) {
    SCOPED_TRACE(path.string());
    const TemporaryFolder folder;
    for (const auto& copy : copies) {
      std::filesystem::copy_file(copy, folder.path() / copy.filename(),
                                 std::filesystem::copy_options::overwrite_existing);
      std::filesystem::permissions(folder.path() / copy.filename(),
                                   std::filesystem::perms::owner_all);
    }
    folder_ = &folder;
    file_name_ = path.filename();
    std::filesystem::remove(folder.path() / file_name_);
    const std::string whole = content_of(path);
    const std::optional<Reading> original = read(whole);
    ++files_;
    std::mt19937_64 random(std::hash<std::string>()(path.filename().string()) + whole.size());
    for (int i = 0; i < places_ && !whole.empty(); ++i) {
      const std::size_t size = random() % range(whole, i);
      const std::size_t fate = judge(original, read(whole.substr(0, size)));
      ++cut_[fate];
      if (fate == kOther && !silent_cuts_) {
        ADD_FAILURE() << "cut to " << size << " bytes it reads as something else without a word";
      }
      std::string flipped = whole;
      flipped[random() % range(whole, i)] ^= static_cast<char>(1 + random() % 255);
      ++flipped_[judge(original, read(flipped))];
    }
  }

  /// Prints what became of all; fails if nothing was read.
  void report() const {
    const auto fates = [](const std::array<int, 4>& n) {
      return fmt::format("{} refused, {} flagged, {} the same, {} other values", n[kRefused],
                         n[kFlagged], n[kSame], n[kOther]);
    };
    fmt::print("{}: {} files, {} places each; cut: {}; a byte flipped: {}\n", name_, files_,
               places_, fates(cut_), fates(flipped_));
    fmt::print(
        "{}: memory up to {:.2f} times files of more than 100 kB; {:.0f} times and {:.0f} MiB "
        "are allowed\n",
        name_, largest_factor_, factor_, constant_ / (1 << 20));
    EXPECT_GT(files_, 0);
    EXPECT_GT(cut_[kRefused] + cut_[kFlagged], 0);
  }

 private:
  enum Fate { kRefused, kFlagged, kSame, kOther };

  // Half of the places are among the first 4 kB, where headers are.
  static std::size_t range(const std::string& whole, int i) {
    return i % 2 == 0 ? std::min<std::size_t>(whole.size(), 4096) : whole.size();
  }

  // Nothing where it was refused.
  std::optional<Reading> read(const std::string& content) {
    const auto path = folder_->write(file_name_.string(), content);
    std::optional<Reading> reading;
    ::alarm(60);  // ends the program
    const std::ptrdiff_t peak = live_memory::peak_in([&] {
      try {
        reading = reader_(path);
      } catch (const InputError& error) {
        EXPECT_FALSE(error.parts().problem.empty());
        EXPECT_FALSE(error.where().file.empty());
      }
    });
    ::alarm(0);
    const auto size = static_cast<double>(content.size());
    EXPECT_LE(static_cast<double>(peak), factor_ * size + constant_)
        << content.size() << " bytes; " << (reading ? reading->flags : "refused");
    // Of small files the constant is nearly all.
    if (size > 1e5) largest_factor_ = std::max(largest_factor_, static_cast<double>(peak) / size);
    return reading;
  }

  static Fate judge(const std::optional<Reading>& original, const std::optional<Reading>& now) {
    if (!now) return kRefused;
    if (original && now->result == original->result) return kSame;
    return original && now->flags == original->flags ? kOther : kFlagged;
  }

  const std::string name_;
  const Reader reader_;
  const double factor_, constant_;
  int places_ = 4, files_ = 0;
  bool silent_cuts_ = false;
  const TemporaryFolder* folder_ = nullptr;
  std::filesystem::path file_name_;
  std::array<int, 4> cut_ = {}, flipped_ = {};
  double largest_factor_ = 0.0;
};

/// The files below ../shared/data with such endings, in the order of their names.
inline std::vector<std::filesystem::path> shared_files(std::initializer_list<const char*> endings) {
  std::vector<std::filesystem::path> paths;
  if (!std::filesystem::exists("../shared/data")) return paths;
  for (const auto& entry : std::filesystem::recursive_directory_iterator("../shared/data")) {
    for (const char* ending : endings) {
      if (entry.path().extension() == ending) paths.push_back(entry.path());
    }
  }
  std::sort(paths.begin(), paths.end());
  return paths;
}

}  // namespace sinew
