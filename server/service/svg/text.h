#pragma once

#include <string>
#include <string_view>

namespace kerf::svg {

// Returns the text of an XML file in UTF-8. Understands UTF-8 and UTF-16, with or without a byte order mark, and takes
// all else as ISO-8859-1, whatever the declaration says: so text that was converted before stays. The mark is removed.
std::string text_of(std::string_view data);

// Returns the text with its data URIs emptied: those that are the whole value of an attribute, and those in url(). They
// hold pictures and fonts, which are not cut.
std::string without_embedded_data(std::string_view text);

}  // namespace kerf::svg
