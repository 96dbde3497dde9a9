#include "scene/accepted_findings.h"

namespace hapton {

// Findings are the faults that `hapton check` looks for; those that a scene accepts are reported as notes.
Result<std::vector<std::string>> read_accepted_findings(const toml::table& object, const std::string& name) {
  std::vector<std::string> accepted;
  const toml::node* node = object.get(kAcceptedFindingsKey);
  if (node == nullptr) return accepted;
  const toml::array* list = node->as_array();
  if (list == nullptr) {
    return fail("{}'{}' in {} must be a list of {}", line_prefix(*node), kAcceptedFindingsKey, name, fmt::join(kAcceptableFindings, ", "));
  }
  for (const toml::node& one : *list) {
    const std::string word = one.value_exact<std::string>().value_or("");
    if (std::find(kAcceptableFindings.begin(), kAcceptableFindings.end(), word) == kAcceptableFindings.end()) {
      return fail("{}'{}' in {} has {}: each must be one of {}", line_prefix(one), kAcceptedFindingsKey, name,
                  word.empty() ? "something" : fmt::format("'{}'", printable(word)), fmt::join(kAcceptableFindings, ", "));
    }
    accepted.push_back(word);
  }
  return accepted;
}

}  // namespace hapton
