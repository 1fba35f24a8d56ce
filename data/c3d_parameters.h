#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace sinew {

/// The byte order and number format of a C3D file; values as its parameter section stores them.
enum class C3dProcessor : unsigned char { kIntel = 84, kDec = 85, kMips = 86 };

/// One parameter of a C3D file as it is stored. Arrays are in Fortran's order: the first dimension
/// runs fastest.
struct C3dParameter {
  std::string name, description;
  bool locked = false;
  std::vector<int> dimensions;  // none for a scalar; each 0 to 255
  // Characters, bytes, 16-bit integers or reals: as many as the dimensions' product.
  std::variant<std::string, std::vector<std::uint8_t>, std::vector<std::int16_t>,
               std::vector<float>>
      values;

  bool operator==(const C3dParameter&) const = default;

  /// The numbers; none for characters. 16-bit integers are signed unless `as_unsigned`.
  std::vector<double> numbers(bool as_unsigned = false) const;
  /// The first number, if there is one.
  std::optional<double> number(bool as_unsigned = false) const;
  /// The texts without the blanks around them: one for a row of characters, else one for each
  /// position in the further dimensions; none for numbers.
  std::vector<std::string> texts() const;

  static C3dParameter of_integers(std::string name, std::vector<int> dimensions,
                                  std::vector<std::int16_t> values);
  static C3dParameter of_reals(std::string name, std::vector<int> dimensions,
                               std::vector<float> values);
  static C3dParameter of_text(std::string name, const std::string& text);
  /// An array of texts, each padded to the longest; at most 255 of at most 255 characters.
  static C3dParameter of_texts(std::string name, const std::vector<std::string>& texts);
};

struct C3dGroup {
  int id = 0;  // 1 to 127
  std::string name, description;
  bool locked = false;
  std::vector<C3dParameter> parameters;

  bool operator==(const C3dGroup&) const = default;
  const C3dParameter* find(std::string_view name) const;  // any case; nullptr if there is none
};

using C3dGroups = std::vector<C3dGroup>;

/// The group of a name in any case, or nullptr. FORCE_PLATFORM also finds the misspellings
/// FORCE_PLATFORMS and FORCE_PLATEFORM that some systems write.
const C3dGroup* find_group(const C3dGroups& groups, std::string_view name);
/// A parameter, or nullptr.
const C3dParameter* find_parameter(const C3dGroups& groups, std::string_view group,
                                   std::string_view name);
/// The first number of a parameter, if it has one.
std::optional<double> find_number(const C3dGroups& groups, std::string_view group,
                                  std::string_view name, bool as_unsigned = false);
/// The numbers of NAME, NAME2, NAME3, ... one after the other: files with more than 255 channels
/// go on there.
std::vector<double> find_numbers(const C3dGroups& groups, std::string_view group,
                                 std::string_view name, bool as_unsigned = false);
std::vector<std::string> find_texts(const C3dGroups& groups, std::string_view group,
                                    std::string_view name);

/// Puts a parameter into a group, in place of one of its name. Makes the group if need be.
void set_parameter(C3dGroups& groups, std::string_view group, C3dParameter parameter);
/// Removes NAME2, NAME3, ... and, with `and_first`, NAME.
void remove_parameters(C3dGroups& groups, std::string_view group, std::string_view name,
                       bool and_first);

}  // namespace sinew
