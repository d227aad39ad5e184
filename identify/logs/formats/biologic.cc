// BioLogic EC-Lab and BT-Lab text (.mpt, .txt): "Nb header lines : N", then time/s, Ecell/V, I/mA
// and many more; or without that preamble; or as derived CSV with semicolons. time/s may hold
// dates.

#include "identify/logs/formats/layout.h"

namespace lipoid {

constinit const Layout kBiologic{
    .name = "biologic",
    .summary = "BioLogic EC-Lab and BT-Lab text export: time/s, Ecell/V or Ewe/V, I/mA",
    .signature = {{"time/s", "ecell/v|ewe/v|<ewe>/v|<ecell>/v|ewe-ece/v"}},
    .columns = {{{.names = "time", .in_order = true},
                 {.names = "i|<i>", .in_order = true},
                 {.names = "ecell|ewe-ece|ewe|<ecell>|<ewe>", .in_order = true},
                 {.names = "temperature", .in_order = true},
                 {.names = "ns"},
                 {.names = "cycle_number"}}},
    .date_order = DateOrder::kMonthFirst,
};

}  // namespace lipoid
