# Purpose: files and captions of figures that are drawn together.
# Inputs:  the functions that draw them, by name.
# Outputs: functions for the directives of ../figures.smk


def pictures(figures, label):
    """Files of figures, by kind; their label in the report has a place for the name."""
    return {
        "png": [
            shown(f"{RESULTS}/figures/{name}.png", "Figures", label.format(name))
            for name in figures
        ],
        "pdf": [f"{RESULTS}/figures/{name}.pdf" for name in figures],
    }


def captions(figures):
    """What each of the figures shows."""
    return "\n\n".join(f"{name}: {caption_of(of)}" for name, of in figures.items())
