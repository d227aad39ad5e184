// Any delimited text with a header that names time, current and voltage in one of the usual ways;
// Landt and PEC exports are read by it as they are.

#include "identify/logs/formats/layout.h"

namespace lipoid {

// `otherwise`: German, French, Spanish, Italian and Chinese; accents are folded before names are
// compared.
constinit const Layout kPlainCsv{
    .name = "plain-csv",
    .summary =
        "time_s,current_A,voltage_V under any usual names and units, any of , ; TAB between them",
    .columns =
        {{{.names = "time|t|test_time|testtime|elapsed|elapsed_time|time_elapsed|total_time|"
                    "run_time|runtime|prog_time|cumulative_time|relative_time|experiment_time|"
                    "seconds|minutes|hours|总时间|测试时间|运行时间|累计时间",
           // Chinese ones above are of the whole test: the plain word below is that of the step.
           .otherwise = "zeit|testzeit|pruefzeit|prufzeit|laufzeit|messzeit|gesamtzeit|temps|"
                        "temps_ecoule|duree|tiempo|tiempo_total|tempo|时间"},
          {.names = "current|i|amps|amp|ampere|amperes|mamps|milliamps|curr|cell_current|"
                    "battery_current|pack_current|measured_current|current_measured|i_cell|i_b|"
                    "i_bat|i_batt|ibat|i_battery",
           .otherwise =
               "strom|zellstrom|batteriestrom|akkustrom|stromstarke|stromstaerke|courant|"
               "courant_batterie|intensite|corriente|corriente_bateria|intensidad|corrente|"
               "电流|电池电流|充放电电流"},
          {.names = "voltage|v|u|e|volt|volts|potential|cell_voltage|battery_voltage|"
                    "pack_voltage|terminal_voltage|measured_voltage|voltage_measured|ecell|ewe|"
                    "v_cell|u_cell|v_b|v_bat|v_batt|vbat|v_battery|u_bat",
           .otherwise =
               "spannung|zellspannung|batteriespannung|akkuspannung|klemmenspannung|tension|"
               "tension_cellule|tension_batterie|tension_bateria|voltaje|voltaje_bateria|"
               "voltaje_celda|tensione|电压|电池电压|单体电压"},
          {.names = "temperature|temp|cell_temperature|temperature_cell|t_cell|cell_t|"
                    "cell_temp|temp_cell|battery_temperature|battery_temp",
           .otherwise = "temperatur|zelltemperatur|temperatur_zelle|temperatura|temperatura_celda|"
                        "temperature_cellule|温度|电池温度"},
          {.names = "step|step_index|step_number|step_id",
           .otherwise = "schritt|schrittnummer|etape|paso|工步|工步号|工步序号"},
          {.names = "cycle|cycle_index|cycle_number|cycle_count",
           .otherwise = "zyklus|zyklusnummer|ciclo|循环|循环号|循环序号"},
          {.names = "state|status|mode|md|step_type|step_name",
           .otherwise = "zustand|etat|estado|状态|工步类型|工步名称"}}},
    .date = {.names = "timestamp|time_stamp|datetime|date_time|date|unix_time|epoch",
             .otherwise = "datum|zeitstempel|fecha|horodatage|日期|系统时间|绝对时间",
             .in_order = true},
    .date_order = DateOrder::kYearFirst,
    .comments = true,
};

}  // namespace lipoid
