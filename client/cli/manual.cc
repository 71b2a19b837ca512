#include "client/cli/manual.h"

#include <algorithm>
#include <cctype>
#include <sstream>

#include "client/cli/app.h"

namespace kerf::cli {
namespace {

// Escapes characters special to man(7): backslashes, dashes (which become hyphens), and a full stop or an apostrophe at
// the beginning of a line.
std::string escape(const std::string& text) {
  std::string escaped;
  for (const char letter : text) {
    if ((letter == '.' || letter == '\'') && (escaped.empty() || escaped.back() == '\n')) escaped += "\\&";
    if (letter == '\\') {
      escaped += "\\e";
    } else if (letter == '-') {
      escaped += "\\-";
    } else {
      escaped += letter;
    }
  }
  return escaped;
}

std::string bold(const std::string& text) {
  return "\\fB" + escape(text) + "\\fR";
}
std::string italic(const std::string& text) {
  return "\\fI" + escape(text) + "\\fR";
}

// Formats paragraphs; examples and lines that begin with a blank stay unchanged.
std::string prose(const std::string& text) {
  std::string page;
  bool verbatim = false;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const bool as_it_is = line.rfind("Example", 0) == 0 || line.rfind(' ', 0) == 0;
    if (as_it_is != verbatim) page += as_it_is ? ".PP\n.nf\n" : ".fi\n";
    verbatim = as_it_is;
    page += line.empty() ? ".PP\n" : escape(line) + "\n";
  }
  return verbatim ? page + ".fi\n" : page;
}

// Returns the name of a value, such as "FILE" or "top|corners|none".
std::string value_name(const CLI::Option& option) {
  std::string name;
  for (const std::string& choice : choices_of(option)) name += (name.empty() ? "" : "|") + choice;
  if (!name.empty()) return name;
  const std::string type = option.get_type_name();
  return type.substr(0, type.find(':', type == "HOST:PORT" ? type.size() : 0));
}

// Adds a final full stop if it is missing.
std::string sentence(const std::string& text) {
  return text.empty() || text.back() == '.' ? text : text + ".";
}

std::string entry(const CLI::Option& option) {
  std::string head;
  for (const std::string& name : option.get_snames()) head += (head.empty() ? "" : ", ") + bold("-" + name);
  for (const std::string& name : option.get_lnames()) head += (head.empty() ? "" : ", ") + bold("--" + name);
  if (head.empty()) head = italic(option.get_name(true));
  if (takes_value(option) && option.nonpositional()) head += " " + italic(value_name(option));
  std::string text = prose(sentence(option.get_description()));
  if (!option.nonpositional() && !choices_of(option).empty()) text += prose("One of " + value_name(option) + ".");
  if (option.nonpositional() && option.get_required()) text += "Required.\n";
  if (!option.get_default_str().empty()) text += prose("Default: " + option.get_default_str() + ".");
  return ".TP\n" + head + "\n" + text;
}

std::string synopsis(const CLI::App& command) {
  std::string line = bold(full_name(command));
  for (const CLI::Option* argument : arguments_of(command)) line += " " + italic(argument->get_name(true));
  if (!options_of(command).empty()) line += " [" + italic("OPTION") + "]...";
  return line;
}

// Describes a command, or its subcommands if it has any.
std::string command_entry(const CLI::App& command) {
  const std::vector<const CLI::App*> below = commands_of(command);
  std::string page;
  for (const CLI::App* each : below) page += command_entry(*each);
  if (!below.empty()) return page;
  page = ".SS " + synopsis(command) + "\n" + prose(command.get_description());
  for (const CLI::Option* argument : arguments_of(command)) page += entry(*argument);
  for (const CLI::Option* option : options_of(command)) {
    if (option != command.get_help_ptr()) page += entry(*option);
  }
  // A table below the help keeps its lines. Commands without one have that of their parent.
  const std::string footer = command.get_footer();
  if (footer != command.get_parent()->get_footer()) page += ".PP\n.nf\n" + escape(footer) + "\n.fi\n";
  return page;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char letter) { return std::toupper(letter); });
  return text;
}

// Lists the commands under the headings of the help, in its order.
std::string commands_by_group(const CLI::App& app) {
  std::vector<std::string> groups;
  for (const CLI::App* command : commands_of(app)) {
    if (std::find(groups.begin(), groups.end(), command->get_group()) == groups.end()) {
      groups.push_back(command->get_group());
    }
  }
  std::string page;
  for (const std::string& group : groups) {
    page += ".SH " + escape(upper(group)) + "\n";
    for (const CLI::App* command : commands_of(app)) {
      if (command->get_group() == group) page += command_entry(*command);
    }
  }
  return page;
}

}  // namespace

std::string manual_page(const CLI::App& app, const ManualText& text, const std::string& version) {
  const bool has_commands = !commands_of(app).empty();
  std::string page = ".TH " + upper(text.title) + " 1 \"\" \"Kerf " + version + "\"\n";
  page += ".SH NAME\n" + escape(text.title) + " \\- " + escape(text.summary) + "\n";
  page += ".SH SYNOPSIS\n" + bold(text.title) + " [" + italic("OPTION") + "]..." +
          (has_commands ? " " + italic("COMMAND") + " ..." : "") + "\n";
  page += ".SH DESCRIPTION\n" + prose(text.description);
  page += ".SH OPTIONS\n";
  for (const CLI::Option* option : options_of(app)) page += entry(*option);
  page += commands_by_group(app);
  for (const auto& [heading, content] : text.sections) page += ".SH " + escape(heading) + "\n" + prose(content);
  return page;
}

}  // namespace kerf::cli
