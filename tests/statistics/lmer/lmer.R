# The values in lmer.json, from lme4 1.1 and lmerTest 3.1: Rscript lmer.R *.csv > lmer.json
suppressMessages({library(lme4); library(lmerTest)})
number <- function(x) paste0("[", paste(format(x, digits = 16), collapse = ", "), "]")
studies <- sapply(commandArgs(TRUE), function(file) {
  d <- read.csv(file, stringsAsFactors = TRUE)
  control <- lmerControl(optimizer = "bobyqa", optCtrl = list(rhoend = 1e-11, maxfun = 1e5), check.conv.singular = "ignore")
  m <- lmerTest::lmer(b ~ specimen + (1 | participant) + (1 | participant:specimen), d, control = control)
  v <- as.data.frame(VarCorr(m)); a <- anova(m)
  pairs <- combn(nlevels(d$specimen), 2)
  rows <- apply(pairs, 2, function(pair) {
    contrast <- replace(numeric(nlevels(d$specimen)), pair, c(1, -1)); contrast[1] <- 0
    number(unlist(contest1D(m, contrast))[1:5])
  })
  sprintf('  "%s": {\n    "variance": %s,\n    "reml": %s,\n    "f_df_p": %s,\n    "pairs": [\n      %s\n    ]\n  }', file,
    number(v$vcov[match(c("participant", "participant:specimen", "Residual"), v$grp)]), number(REMLcrit(m)),
    number(c(a$`F value`, a$DenDF, a$`Pr(>F)`)), paste(rows, collapse = ",\n      "))
})
cat("{\n", paste(studies, collapse = ",\n"), "\n}\n", sep = "")
