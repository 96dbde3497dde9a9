#pragma once

#include <string>

namespace hapton {

// Wide text, one code point a character as in hidapi's strings, as UTF-8. Null: nothing. RT: no.
std::string to_utf8(const wchar_t* wide);

}  // namespace hapton
