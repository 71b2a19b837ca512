#pragma once

#include <string>

// Brings the text of a DXF file to UTF-8 by the code page that its header names.
namespace kerf::dxf {

struct DecodedText {
  std::string text;    // UTF-8
  std::string unread;  // A code page that was not read, so that names were taken as ISO-8859-1; else empty.
};

// Decodes a file. UTF-16 is known by its mark, and bytes that are well-formed UTF-8 are that. Others are in the code
// page of $DWGCODEPAGE, or in ISO-8859-1 if there is none. Characters written as \M+nXXXX become UTF-8, too.
DecodedText decoded(std::string data);

}  // namespace kerf::dxf
