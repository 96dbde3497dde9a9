#pragma once

#include <optional>
#include <string_view>
#include <vector>

namespace hapton {

// Reads "0.1,0,-0.05": at least one number, without spaces; inf and nan are numbers too. None: the text has another form. RT: no.
std::optional<std::vector<double>> read_number_list(std::string_view text);

}  // namespace hapton
