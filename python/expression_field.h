#pragma once

#include <array>
#include <map>
#include <memory>
#include <string>

#include "core/base/result.h"
#include "core/effects/effect_sample.h"

namespace hapton::python {

// A force by three expressions of position (x, y, z, m), velocity (vx, vy, vz, m/s) and time since the fields were set (t, s), with
// constants that the user names. muParser compiles them once. Frame: W. Bound: max_force_n; a result that is not finite gives no force. RT:
// force yes (no heap after make). Threads: one at a time; a copy has its own variables.
class ExpressionField {
 public:
  // texts: along x, y and z. Error, one line: what is wrong with which text, or a name or value that a constant cannot have.
  static Result<ExpressionField> make(const std::array<std::string, 3>& texts, const std::map<std::string, double>& constants,
                                      double max_force_n);
  ExpressionField(const ExpressionField& other);
  ExpressionField& operator=(const ExpressionField& other);
  ExpressionField(ExpressionField&&) noexcept;
  ExpressionField& operator=(ExpressionField&&) noexcept;
  ~ExpressionField();

  Vec3 force(const EffectSample& hand) noexcept;

 private:
  struct Program;
  explicit ExpressionField(std::unique_ptr<Program> program);

  std::unique_ptr<Program> program_;
};

}  // namespace hapton::python
