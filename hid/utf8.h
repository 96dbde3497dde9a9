#pragma once

#include <string>

namespace hapton {

// Converts wide text, with one code point in each character as in hidapi's strings, to UTF-8. Null: empty text. RT: no.
std::string to_utf8(const wchar_t* wide);

}  // namespace hapton
