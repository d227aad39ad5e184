#include "tools/commands/latex_option.h"

#include <fmt/format.h>

#include "model/core/atomic_file.h"
#include "model/core/foreign_text.h"
#include "model/core/run_record.h"

namespace lipoid {

void LatexOption::AddTo(cli::CommandLine& line) {
  line.OutputOption(
      "latex", file_, "TEX", "write the tables for LaTeX, with the rules of booktabs");
}

std::string LatexOption::Table(const cli::TextTable& table, std::string_view caption) {
  tables_ += "\n" + table.Latex(caption);
  return table.Text();
}

void LatexOption::Write(const cli::CommandLine& line) const {
  if (file_.empty()) return;
  WriteFileAtomically(file_,
                      fmt::format("% lipoid {} ({}): {}\n% \\usepackage{{booktabs}}\n{}",
                                  Version(),
                                  GitCommit(),
                                  ForeignText(line.CommandText()),
                                  tables_));
}

}  // namespace lipoid
