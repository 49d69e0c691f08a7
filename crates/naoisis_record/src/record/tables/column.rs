//! Columns of tables: their definitions and their values.

/// The type of the values of a column.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[non_exhaustive]
pub enum ColumnKind {
    /// Whole numbers of 64 bits.
    Whole,
    /// Numbers of single precision.
    Single,
    /// Numbers of double precision.
    Double,
    /// Texts.
    Text,
}

/// The definition of a column.
#[derive(Debug)]
pub struct Column {
    /// Its name, with the unit of its values.
    pub name: &'static str,
    /// Meaning of the values.
    pub description: &'static str,
    /// Type of the values.
    pub kind: ColumnKind,
    /// Whether values may be missing.
    pub is_optional: bool,
}

/// The values of a column that are present.
#[derive(Clone, PartialEq, Debug)]
#[non_exhaustive]
pub enum Cells {
    /// Whole numbers.
    Whole(Vec<i64>),
    /// Numbers of single precision.
    Single(Vec<f32>),
    /// Numbers of double precision.
    Double(Vec<f64>),
    /// Texts.
    Text(Vec<String>),
}

/// The values of a column.
#[derive(Clone, PartialEq, Debug)]
pub struct ColumnValues {
    /// Whether the value of each row is present (1) or missing (0).
    pub presence: Vec<i16>,
    /// The present values.
    pub cells: Cells,
}

impl ColumnValues {
    pub(super) fn new(column: &Column) -> Self {
        let cells = match column.kind {
            ColumnKind::Whole => Cells::Whole(Vec::new()),
            ColumnKind::Single => Cells::Single(Vec::new()),
            ColumnKind::Double => Cells::Double(Vec::new()),
            ColumnKind::Text => Cells::Text(Vec::new()),
        };
        Self { presence: Vec::new(), cells }
    }

    /// The number of rows.
    pub fn len(&self) -> usize {
        self.presence.len()
    }

    /// Returns whether the column has no rows.
    pub fn is_empty(&self) -> bool {
        self.presence.is_empty()
    }

    pub(super) fn clear(&mut self) {
        self.presence.clear();
        match &mut self.cells {
            Cells::Whole(cells) => cells.clear(),
            Cells::Single(cells) => cells.clear(),
            Cells::Double(cells) => cells.clear(),
            Cells::Text(cells) => cells.clear(),
        }
    }
}

/// A type of values in a column.
pub(super) trait Cell {
    const KIND: ColumnKind;
    const IS_OPTIONAL: bool = false;

    fn push_to(self, column: &mut ColumnValues);
}

macro_rules! cell {
    ($($type:ty => $kind:ident),*) => {
        $(impl Cell for $type {
            const KIND: ColumnKind = ColumnKind::$kind;

            fn push_to(self, column: &mut ColumnValues) {
                if let Cells::$kind(cells) = &mut column.cells {
                    cells.push(self);
                    column.presence.push(1);
                }
            }
        })*
    };
}

cell!(i64 => Whole, f32 => Single, f64 => Double, String => Text);

impl<C: Cell> Cell for Option<C> {
    const KIND: ColumnKind = C::KIND;
    const IS_OPTIONAL: bool = true;

    fn push_to(self, column: &mut ColumnValues) {
        match self {
            Some(cell) => cell.push_to(column),
            None => column.presence.push(0),
        }
    }
}

/// A row of a table. Its fields are the columns.
pub(super) trait TableRow {
    const DESCRIPTION: &'static str;
    const COLUMNS: &'static [Column];

    fn push_to(self, columns: &mut [ColumnValues]);
}

/// Defines the rows of a table. The documentation of a field describes its column.
macro_rules! table_row {
    ($(#[doc = $about:literal])+ $row:ident { $($(#[doc = $description:literal])+ $column:ident: $type:ty,)* }) => {
        $(#[doc = $about])+
        pub(super) struct $row {
            $($(#[doc = $description])+ pub $column: $type,)*
        }

        impl TableRow for $row {
            const DESCRIPTION: &'static str = concat!($($about),+).trim_ascii();
            const COLUMNS: &'static [Column] = &[$(Column {
                name: stringify!($column),
                description: concat!($($description),+).trim_ascii(),
                kind: <$type as Cell>::KIND,
                is_optional: <$type as Cell>::IS_OPTIONAL,
            }),*];

            fn push_to(self, columns: &mut [ColumnValues]) {
                let mut columns = columns.iter_mut();
                $(if let Some(column) = columns.next() {
                    self.$column.push_to(column);
                })*
            }
        }
    };
}

pub(super) use table_row;
