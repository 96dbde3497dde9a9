#include "python/expression_field.h"

#include <muParser.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/effects/bounded_force.h"

namespace hapton::python {
namespace {

constexpr std::size_t kMaxLetters = 1000;  // far above any formula that a person writes; a free choice
constexpr double kPi = 3.14159265358979323846;
constexpr std::array<const char*, 7> kVariables = {"x", "y", "z", "vx", "vy", "vz", "t"};

bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

// muParser accepts any name and any value; some names would hide a variable or a function.
Result<void> check_constant(const std::string& name, double value) {
  const bool is_name = !name.empty() && is_letter(name[0]) && std::ranges::all_of(name, [](char c) { return is_letter(c) || is_digit(c); });
  if (!is_name) return fail("'{}' cannot name a constant; use letters, digits and _, with a letter or _ first", name);
  const bool is_taken = name == "pi" || std::ranges::find(kVariables, name) != kVariables.end() || mu::Parser().GetFunDef().contains(name);
  if (is_taken) return fail("the constant {} has the name of a variable or a function; choose another one", name);
  if (!std::isfinite(value)) return fail("{} is {}; give a finite number", name, value);
  return {};
}

}  // namespace

// Must not be moved: the parsers point to its variables.
struct ExpressionField::Program {
  std::array<std::string, 3> texts;
  std::map<std::string, double> constants;
  double max_force_n = 0.0;
  std::array<double, kVariables.size()> variables = {};
  std::array<mu::Parser, 3> parsers;

  void compile(std::size_t axis) {
    mu::Parser& parser = parsers[axis];
    for (std::size_t v = 0; v < variables.size(); ++v) parser.DefineVar(kVariables[v], &variables[v]);
    parser.DefineConst("pi", kPi);
    for (const auto& [name, value] : constants) parser.DefineConst(name, value);
    parser.SetExpr(texts[axis]);
    (void)parser.Eval();  // the first call compiles the text and allocates the memory
  }
};

Result<ExpressionField> ExpressionField::make(const std::array<std::string, 3>& texts, const std::map<std::string, double>& constants,
                                              double max_force_n) {
  static constexpr const char* kAxes[] = {"fx", "fy", "fz"};
  auto program = std::make_unique<Program>();
  program->texts = texts;
  program->constants = constants;
  program->max_force_n = max_force_n;
  for (const auto& [name, value] : constants) {
    if (const auto good = check_constant(name, value); !good) return tl::unexpected(good.error());
  }
  for (std::size_t axis = 0; axis < texts.size(); ++axis) {
    if (texts[axis].size() > kMaxLetters) return fail("{} has {} letters; give at most {}", kAxes[axis], texts[axis].size(), kMaxLetters);
    try {
      program->compile(axis);
    } catch (const mu::Parser::exception_type& error) {
      return fail("{} = \"{}\": {} An expression has x, y, z, vx, vy, vz, t, pi and the constants given by keyword", kAxes[axis],
                  texts[axis], error.GetMsg());
    }
  }
  return ExpressionField(std::move(program));
}

ExpressionField::ExpressionField(std::unique_ptr<Program> program) : program_(std::move(program)) {}
ExpressionField::ExpressionField(ExpressionField&&) noexcept = default;
ExpressionField& ExpressionField::operator=(ExpressionField&&) noexcept = default;
ExpressionField::~ExpressionField() = default;

ExpressionField::ExpressionField(const ExpressionField& other) : program_(std::make_unique<Program>()) {
  program_->texts = other.program_->texts;
  program_->constants = other.program_->constants;
  program_->max_force_n = other.program_->max_force_n;
  for (std::size_t axis = 0; axis < program_->texts.size(); ++axis) program_->compile(axis);
}

ExpressionField& ExpressionField::operator=(const ExpressionField& other) { return *this = ExpressionField(other); }

Vec3 ExpressionField::force(const EffectSample& hand) noexcept {
  Vec3 force_n;
  try {
    for (int axis = 0; axis < 3; ++axis) {
      // Set before each of the three: an expression may assign to variables.
      program_->variables = {hand.p_SD.x(), hand.p_SD.y(), hand.p_SD.z(), hand.v_SD.x(), hand.v_SD.y(), hand.v_SD.z(), hand.time_s};
      force_n[axis] = program_->parsers[static_cast<std::size_t>(axis)].Eval();
    }
  } catch (...) {
    return Vec3::Zero();
  }
  return bounded_force(force_n, program_->max_force_n);
}

}  // namespace hapton::python
