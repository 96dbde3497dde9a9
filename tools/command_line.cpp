#include "tools/command_line.h"

#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <ranges>
#include <string_view>
#include <utility>

#include "core/base/similar_word.h"
#include "runtime/flag_checks.h"

namespace hapton {

CommandOption CommandOption::required() const { return CommandOption(*option_->required()); }
CommandOption CommandOption::shows_default() const { return CommandOption(*option_->capture_default_str()); }
CommandOption CommandOption::between(int least, int most) const { return CommandOption(*option_->check(hapton::between(least, most))); }
CommandOption CommandOption::between(std::size_t least, std::size_t most) const {
  return CommandOption(*option_->check(hapton::between(static_cast<double>(least), static_cast<double>(most))));
}
CommandOption CommandOption::between(double least, double most) const {
  return CommandOption(*option_->check(hapton::between(least, most)));
}
CommandOption CommandOption::positive(const std::string& what) const { return CommandOption(*option_->check(above_zero(what))); }
CommandOption CommandOption::not_negative(const std::string& what) const { return CommandOption(*option_->check(zero_or_more(what))); }
CommandOption CommandOption::one_of(const std::vector<std::string>& words) const {
  return CommandOption(*option_->check(CLI::IsMember(words)));
}
CommandOption CommandOption::one_of_names(const std::string& names, std::function<bool(const std::string&)> accepts_too) const {
  const auto check = [names, accepts_too = std::move(accepts_too)](const std::string& text) -> std::string {
    if (accepts_too && accepts_too(text)) return {};
    std::vector<std::string_view> known;
    for (const auto name : std::views::split(std::string_view(names), std::string_view(", "))) known.emplace_back(name.begin(), name.end());
    if (std::ranges::find(known, text) != known.end()) return {};
    return fmt::format("'{}' is not known{}", text, similar_word_hint(text, known));
  };
  return CommandOption(*option_->check(CLI::Validator(check, "")));
}
CommandOption CommandOption::existing_folder() const { return CommandOption(*option_->check(CLI::ExistingDirectory)); }
CommandOption CommandOption::folder_to_write() const { return CommandOption(*option_->check(hapton::folder_to_write())); }
CommandOption CommandOption::file_to_write() const { return CommandOption(*option_->check(hapton::file_to_write())); }
CommandOption CommandOption::again_for_more() const { return CommandOption(*option_->expected(1)->take_all()); }
CommandOption CommandOption::needs(CommandOption other) const { return CommandOption(*option_->needs(other.option_)); }
CommandOption CommandOption::excludes(CommandOption other) const { return CommandOption(*option_->excludes(other.option_)); }

CommandLine CommandLine::add_subcommand(const std::string& name, const std::string& help) const {
  return CommandLine(*app_->add_subcommand(name, help));
}

CommandLine CommandLine::add_old_subcommand(const std::string& old_name, const std::string& name) const {
  return CommandLine(*app_->add_subcommand(old_name, "Old name of " + name)->group(""));
}

CommandLine CommandLine::add_group(const std::string& name, const std::string& help) const {
  return CommandLine(*app_->add_option_group(name, help));
}

template <class T>
CommandOption CommandLine::add_option(const std::string& name, T& into, const std::string& help) const {
  return CommandOption(*app_->add_option(name, into, help));
}
template CommandOption CommandLine::add_option(const std::string&, std::string&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, std::filesystem::path&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, int&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, unsigned&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, std::size_t&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, double&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, std::optional<int>&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, std::optional<std::uint64_t>&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, std::optional<double>&, const std::string&) const;
template CommandOption CommandLine::add_option(const std::string&, std::vector<std::string>&, const std::string&) const;

CommandOption CommandLine::add_number(const std::string& name, std::function<void(double)> take, const std::string& help) const {
  return CommandOption(*app_->add_option_function<double>(name, std::move(take), help));
}

CommandOption CommandLine::add_flag(const std::string& name, bool& into, const std::string& help) const {
  return CommandOption(*app_->add_flag(name, into, help));
}

void CommandLine::add_old_option(const std::string& old_name, CommandOption option) const {
  CLI::Option* const new_option = option.option_;
  const auto pass_on = [old_name, new_option](const std::string& word) {
    fmt::print(stderr, "{} is now {}\n", old_name, new_option->get_name());
    new_option->add_result(word);
    new_option->run_callback();
  };
  // CLI11's excludes() is not used: it works in both directions, so --help would list the hidden option as an empty name.
  const auto excludes_new = [old_name, new_option](const std::string&) {
    return new_option->count() > 0 ? old_name + " excludes " + new_option->get_name() + ", its name now" : std::string();
  };
  app_->add_option_function<std::string>(old_name, pass_on, "Old name of " + new_option->get_name())->check(excludes_new)->group("");
}

CommandLine CommandLine::require_options(std::size_t least, std::size_t most) const {
  return CommandLine(*app_->require_option(least, most));
}

CommandLine CommandLine::require_subcommands(std::size_t least, std::size_t most) const {
  return CommandLine(*app_->require_subcommand(least, most));
}

bool CommandLine::has_subcommand() const { return !app_->get_subcommands().empty(); }
void CommandLine::on_run(std::function<void()> run) const { app_->callback(std::move(run)); }

}  // namespace hapton
