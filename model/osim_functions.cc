#include <fmt/format.h>

#include <stdexcept>
#include <string_view>

#include "model/osim_reader.h"

namespace sinew::osim {
namespace {

std::vector<double> required_numbers(const XmlFile& xml, pugi::xml_node element, const char* name) {
  const pugi::xml_node child = element.child(name);
  if (!child) {
    xml.fail(element, {fmt::format("<{}> has no <{}>", element.name(), name),
                       fmt::format("a <{}> element with its values", name), "", "Add the values."});
  }
  return xml.numbers(child);
}

double required_number(const XmlFile& xml, pugi::xml_node element, const char* name) {
  const std::optional<double> value = xml.number(element, name);
  if (!value) {
    xml.fail(element, {fmt::format("<{}> has no <{}>", element.name(), name), "one number", "",
                       "Add the value."});
  }
  return *value;
}

LinearFunction read_linear(const XmlFile& xml, pugi::xml_node element) {
  if (!element.child("coefficients")) return {};
  const std::vector<double> c = required_numbers(xml, element, "coefficients");
  if (c.size() != 2) {
    xml.fail(element,
             {"<LinearFunction> has the wrong number of coefficients", "2 (slope and intercept)",
              std::to_string(c.size()), "Use a PolynomialFunction for higher powers."});
  }
  return {c[0], c[1]};
}

GcvSpline read_gcv_spline(const XmlFile& xml, pugi::xml_node element) {
  GcvSpline spline;
  spline.half_order = static_cast<int>(xml.number(element, "half_order").value_or(3.0));
  spline.x = required_numbers(xml, element, "x");
  spline.y = required_numbers(xml, element, "y");
  if (xml.number(element, "error_variance").value_or(0.0) != 0.0) {
    xml.fail(element.child("error_variance"),
             {"a <GCVSpline> that smooths its points is not supported", "<error_variance> 0",
              xml.text(element, "error_variance"), "Replace y by the smoothed values."});
  }
  return spline;
}

ScalarFunction read_multiplier(const XmlFile& xml, pugi::xml_node element) {
  const std::optional<ScalarFunction> inner = find_function(xml, element, "function");
  if (!inner) {
    xml.fail(element,
             {"<MultiplierFunction> has no function in it",
              "a <function> element with a function such as SimmSpline", "", "Add the function."});
  }
  ScalarFunction scaled = *inner;
  scaled.scale *= xml.number(element, "scale").value_or(1.0);
  return scaled;
}

ScalarFunction read_unchecked(const XmlFile& xml, pugi::xml_node element) {
  const std::string_view kind = element.name();
  const auto points = [&](auto function) {
    function.x = required_numbers(xml, element, "x");
    function.y = required_numbers(xml, element, "y");
    return ScalarFunction{function};
  };
  if (kind == "Constant") return {ConstantFunction{xml.number(element, "value").value_or(0.0)}};
  if (kind == "LinearFunction") return {read_linear(xml, element)};
  if (kind == "PolynomialFunction") {
    return {PolynomialFunction{required_numbers(xml, element, "coefficients")}};
  }
  if (kind == "Sine") {
    const auto value = [&](const char* name, double standard) {
      return xml.number(element, name).value_or(standard);
    };
    return {SineFunction{value("amplitude", 1.0), value("omega", 1.0), value("phase", 0.0),
                         value("offset", 0.0)}};
  }
  if (kind == "SimmSpline" || kind == "NaturalCubicSpline" || kind == "natCubicSpline") {
    return points(SimmSpline{});
  }
  if (kind == "PiecewiseLinearFunction") return points(PiecewiseLinearFunction{});
  if (kind == "PiecewiseConstantFunction") {
    return points(PiecewiseConstantFunction{});
  }
  if (kind == "GCVSpline") return {read_gcv_spline(xml, element)};
  if (kind == "StepFunction") {
    return {StepFunction{required_number(xml, element, "transition_start_time"),
                         required_number(xml, element, "transition_end_time"),
                         xml.number(element, "start_value").value_or(0.0),
                         xml.number(element, "end_value").value_or(1.0)}};
  }
  if (kind == "MultiplierFunction") return read_multiplier(xml, element);
  xml.fail(element,
           {fmt::format("<{}> is a kind of function that is not supported", element.name()),
            "Constant, LinearFunction, PolynomialFunction, Sine, SimmSpline, GCVSpline, "
            "PiecewiseLinearFunction, PiecewiseConstantFunction, StepFunction or "
            "MultiplierFunction",
            "", "Replace it by a spline through its values."});
}

}  // namespace

ScalarFunction read_function(const XmlFile& xml, pugi::xml_node element) {
  const ScalarFunction function = read_unchecked(xml, element);
  try {
    CompiledFunction{function};
  } catch (const std::invalid_argument& error) {
    xml.fail(element, {error.what(), "", "", "Correct the function's values."});
  }
  return function;
}

std::optional<ScalarFunction> find_function(const XmlFile& xml, pugi::xml_node parent,
                                            const char* wrapper) {
  const pugi::xml_node wrapped = parent.child(wrapper);
  for (const pugi::xml_node element : (wrapped ? wrapped : parent).children()) {
    if (element.type() != pugi::node_element) continue;
    // Without a wrapper the function is the child that carries the wrapper's name as its own.
    if (!wrapped && std::string_view(element.attribute("name").value()) != wrapper) continue;
    return read_function(xml, element);
  }
  return std::nullopt;
}

}  // namespace sinew::osim
